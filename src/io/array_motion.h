/// A motion whose vertices and faces are NumPy arrays.
#pragma once

#include <algorithm>

#include "base/try.h"
#include "io/npy.h"
#include "io/readers.h"

namespace foldproof::io {

/// Names of arrays that may be meant, without .npy.
struct ArrayNames {
  std::vector<std::string> vertices, faces;
};
/// Those of an archive with these members, in any case: the usual ones and what others use. The usual ones if
/// there are none.
ArrayNames find_arrays(std::span<const std::string> members);

/// The error for several arrays that may be meant.
tl::unexpected<Error> several_arrays(const std::string& path, const char* what,
                                     std::span<const std::string> names);

/// The array of faces, of those with these names. Error: there are several.
Result<std::string> choose_faces(const std::string& path, const ArrayNames& names);

/// The array of vertices: of several, the only one that has frames. `open`: a name to its open array. Error:
/// it is not clear which is meant.
template <class Open>
auto open_vertices(const std::string& path, const ArrayNames& names, const Open& open) -> decltype(open("")) {
  if (names.vertices.size() == 1) return open(names.vertices[0]);
  const auto unclear = several_arrays(path, "vertices", names.vertices);
  decltype(open("")) with_frames = unclear;
  for (const std::string& name : names.vertices) {
    auto array = FOLDPROOF_TRY(open(name));
    if (array->header().shape.size() != 3) continue;
    if (with_frames) return unclear;
    with_frames = std::move(array);
  }
  return with_frames;
}

/// Of each vertex, the one that it is merged into (MotionInfo::merged). Error: the array is no such map.
Result<std::vector<Index>> read_merged(NpyArray& array, Index vertices);

/// Vertices are read frame by frame.
class ArrayMotion final : public Motion {
 public:
  /// `archive`: what `vertices` is in, or null.
  ArrayMotion(std::string name, std::unique_ptr<NpyArray> vertices, std::shared_ptr<void> archive)
      : name_(std::move(name)), archive_(std::move(archive)), vertices_(std::move(vertices)) {}

  /// Error: the arrays are no motion.
  Result<void> open(NpyArray& faces);
  void set_parts(ObjectParts parts) { info_.parts = std::move(parts); }

  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  const MotionInfo& info() const override { return info_; }
  Index frame_count() const override { return frames_; }
  Result<void> read_frame(Index k, std::span<double> out) override;

 private:
  Result<void> check_vertices();
  Result<void> read_faces(NpyArray& faces);

  std::string name_;
  std::shared_ptr<void> archive_;  // declared before the array, which reads from it
  std::unique_ptr<NpyArray> vertices_;
  std::uint64_t vertex_count_ = 0;
  Index frames_ = 0;
  Topology topology_;
  MotionInfo info_;
  std::vector<char> buffer_;
};

/// The motion; its vertices are merged by the array `merged` among `members`, if there is one and
/// ReadOptions::weld does not say otherwise. `open`: as in open_vertices.
template <class Open>
Result<std::unique_ptr<Motion>> with_merged(std::unique_ptr<Motion> motion,
                                            const std::vector<std::string>& members,
                                            const ReadOptions& options, const Open& open) {
  if (options.weld != Weld::ByFormat || std::ranges::find(members, "merged.npy") == members.end())
    return motion;
  const auto merged = FOLDPROOF_TRY(open("merged"));
  auto map = FOLDPROOF_TRY(read_merged(*merged, motion->topology().vertex_count()));
  return merge(std::move(motion), std::move(map), "its array 'merged'", "check with --no-weld");
}

}  // namespace foldproof::io
