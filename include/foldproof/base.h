/// Basics that every room uses: index type, vectors, errors as values.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

namespace foldproof {

/// Id of a vertex, edge, triangle, frame or object; counts from zero.
using Index = std::uint32_t;
inline constexpr Index kNoIndex = 0xffffffffu;

/// A position or direction in mesh units.
using Vec3 = Eigen::Vector3d;

/// Why a file, mesh or argument was refused. `line()` is what a person reads.
struct Error {
  std::string where;    ///< File and place: "walk.obj:12", "frame 17 of run/*.ply", "--frames".
  std::string problem;  ///< What is wrong: "face refers to vertex 99, but there are 42".
  std::string mend;     ///< What to do about it: "export the mesh again".

  /// "where: problem; mend" on one line. Control characters that came from a file are shown as '?'.
  std::string line() const;
};

/// A value, or the reason there is none. The library never throws on bad input, prints or exits.
template <class T>
using Result = tl::expected<T, Error>;

/// Shorthand for `return` from a function that gives a Result.
inline tl::unexpected<Error> fail(std::string where, std::string problem, std::string mend) {
  return tl::unexpected<Error>(Error{std::move(where), std::move(problem), std::move(mend)});
}

/// The library's version, "major.minor.patch".
const char* version();

}  // namespace foldproof
