/// Basics that every module uses: index type, vectors, errors as values.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "foldproof/vec3.h"

namespace foldproof {

/// Id of a vertex, edge, triangle, frame or object; counts from zero.
using Index = std::uint32_t;
inline constexpr Index kNoIndex = 0xffffffffu;

/// What kind of error it is, for callers that branch on it.
enum class ErrorCode : std::uint8_t {
  InvalidArgument,    ///< A setting, a size or a name that the caller gave.
  NonFinite,          ///< A coordinate or another number is infinite or NaN.
  InvalidMesh,        ///< Triangles, edges or a hierarchy that do not fit together.
  InvalidFile,        ///< A file whose content is damaged or contradicts itself.
  UnsupportedFormat,  ///< A file, or a part of it, of a kind that is not read or written here.
  FileAccess,         ///< A file or socket that cannot be opened, read, written or listened on.
  LimitExceeded,      ///< More than a limit that is stated, or than memory, allows.
  NotLearned,         ///< A model lacks what is asked of it, or poses are too few or too alike to learn it.
  Interrupted,        ///< The caller cancelled.
  Ambiguous,          ///< Files that may mean two things; the caller has to say which.
};

/// Why a file, mesh or argument was rejected. `line()` is the message for people.
struct Error {
  std::string where;    ///< File and position, or argument: "walk.obj:12", "--frames".
  std::string problem;  ///< What is wrong: "face refers to vertex 99, but there are 42".
  std::string remedy;   ///< What to do about it: "export the mesh again".
  ErrorCode code = ErrorCode::InvalidArgument;

  /// "where: problem; remedy" on one line. Control characters that came from a file become '?'.
  std::string line() const;
};

/// A value, or the reason there is none. The library never throws on bad input, prints or exits.
template <class T>
using Result = tl::expected<T, Error>;

/// Shorthand for `return` from a function that returns a Result.
inline tl::unexpected<Error> fail(ErrorCode code, std::string where, std::string problem,
                                  std::string remedy) {
  return tl::unexpected<Error>(Error{std::move(where), std::move(problem), std::move(remedy), code});
}
/// The same with ErrorCode::InvalidArgument.
inline tl::unexpected<Error> fail(std::string where, std::string problem, std::string remedy) {
  return fail(ErrorCode::InvalidArgument, std::move(where), std::move(problem), std::move(remedy));
}

/// The library's version, "major.minor.patch".
const char* version();

/// How the library was built and what it uses here: compiler, threads and how many, instruction set of its
/// vector code, as in "GCC 12.2.0, threads oneTBB (8), AVX-512". No answer depends on the latter two.
std::string build_info();

}  // namespace foldproof
