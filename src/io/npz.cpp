// NumPy archives as motions. Vertices are read frame by frame.
#include <fmt/format.h>

#include "base/try.h"
#include "io/bytes.h"
#include "io/npz_array.h"
#include "io/npz_parts.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

constexpr const char* kNameArrays = "save arrays named 'faces' and 'vertices'";

class NpzMotion final : public Motion {
 public:
  explicit NpzMotion(std::string path) : name_(std::move(path)) {}

  Result<void> open() {
    std::uint64_t bytes = 0;
    archive_ = FOLDPROOF_TRY(open_archive(name_, bytes));
    NpzArray faces;
    for (const auto& [array, name] : {std::pair(&faces, "faces"), std::pair(&vertices_, "vertices")}) {
      FOLDPROOF_TRY(array->open(archive_.get(), name_, bytes, name, kNameArrays));
    }
    FOLDPROOF_TRY(check_vertices());
    FOLDPROOF_TRY(read_faces(faces));
    parts_ = FOLDPROOF_TRY(npz_parts(archive_.get(), name_, bytes, topology_.triangles().size()));
    return {};
  }

  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  const ObjectParts& parts() const override { return parts_; }
  Index frame_count() const override { return frames_; }

  Result<void> read_frame(Index k, std::span<double> out) override {
    FOLDPROOF_TRY(check_request(*this, k, out));
    const NpyHeader& header = vertices_.header();
    buffer_.resize(out.size() * header.item_bytes);
    FOLDPROOF_TRY(vertices_.read_at(k * std::uint64_t{buffer_.size()}, buffer_));
    const char* bytes = buffer_.data();
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = header.item_bytes == 8 ? load<double>(bytes + 8 * i, header.order)
                                      : static_cast<double>(load<float>(bytes + 4 * i, header.order));
    }
    return check_finite(fmt::format("{}, frame {}", vertices_.where(), k), out);
  }

 private:
  Result<void> check_vertices() {
    const NpyHeader& header = vertices_.header();
    if (header.kind != 'f' || header.item_bytes < 4) {
      return fail(ErrorCode::UnsupportedFormat, vertices_.where(), "is not float32 or float64",
                  "save vertices.astype('float64')");
    }
    const auto& shape = header.shape;
    if ((shape.size() != 2 && shape.size() != 3) || shape.back() != 3) {
      return fail(ErrorCode::InvalidFile, vertices_.where(), "is not of shape frames x n x 3 (or n x 3)",
                  "reshape it before saving");
    }
    const std::uint64_t frames = shape.size() == 3 ? shape[0] : 1;
    vertex_count_ = shape[shape.size() - 2];
    if (vertex_count_ > kMaxVertices || frames >= kNoIndex) {
      return fail(ErrorCode::LimitExceeded, vertices_.where(), "has too many vertices or frames",
                  "split the motion");
    }
    frames_ = static_cast<Index>(frames);
    return {};
  }

  Result<void> read_faces(NpzArray& faces) {
    const NpyHeader& header = faces.header();
    if (header.kind != 'i' && header.kind != 'u') {
      return fail(ErrorCode::UnsupportedFormat, faces.where(), "does not hold integers",
                  "save faces.astype('int32')");
    }
    if (header.shape.size() != 2 || header.shape[1] != 3 || header.shape[0] > kMaxTriangles) {
      return fail(ErrorCode::InvalidFile, faces.where(), "is not of shape triangles x 3",
                  "triangulate the faces and reshape them");
    }
    std::vector<char> bytes(faces.elements() * header.item_bytes);
    FOLDPROOF_TRY(faces.read_at(0, bytes));
    std::vector<Triangle> triangles(header.shape[0]);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int64_t v = load_integer(bytes.data() + (3 * i + k) * header.item_bytes, header);
        if (v < 0 || static_cast<std::uint64_t>(v) >= vertex_count_) {
          return fail(ErrorCode::InvalidFile, fmt::format("{}, face {}", faces.where(), i),
                      fmt::format("refers to a vertex that does not exist: there are {}, counting from 0",
                                  vertex_count_),
                      kSaveArrayAgain);
        }
        triangles[i][k] = static_cast<Index>(v);
      }
    }
    topology_ = FOLDPROOF_TRY(Topology::make(static_cast<Index>(vertex_count_), std::move(triangles)));
    return {};
  }

  std::string name_;
  Archive archive_;  // declared before the array, which reads from it
  NpzArray vertices_;
  std::uint64_t vertex_count_ = 0;
  Index frames_ = 0;
  Topology topology_;
  ObjectParts parts_;
  std::vector<char> buffer_;
};

}  // namespace

Result<std::unique_ptr<Motion>> open_npz(const std::string& path) {
  auto motion = std::make_unique<NpzMotion>(path);
  FOLDPROOF_TRY(motion->open());
  return motion;
}

}  // namespace foldproof::io
