/// A motion whose vertices and faces are NumPy arrays.
#pragma once

#include "io/npy.h"
#include "io/readers.h"

namespace foldproof::io {

/// Names of arrays, without .npy.
struct ArrayNames {
  std::string vertices, faces;
};
/// Those of an archive with these members, in any case: the usual ones and what others use. The usual ones if
/// there are none.
ArrayNames find_arrays(std::span<const std::string> members);

/// Vertices are read frame by frame.
class ArrayMotion final : public Motion {
 public:
  /// `archive`: what `vertices` is in, or null.
  ArrayMotion(std::string name, std::unique_ptr<NpyArray> vertices, std::shared_ptr<void> archive)
      : name_(std::move(name)), archive_(std::move(archive)), vertices_(std::move(vertices)) {}

  /// Error: the arrays are no motion.
  Result<void> open(NpyArray& faces);
  void set_parts(ObjectParts parts) { parts_ = std::move(parts); }

  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  const ObjectParts& parts() const override { return parts_; }
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
  ObjectParts parts_;
  std::vector<char> buffer_;
};

}  // namespace foldproof::io
