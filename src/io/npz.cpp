// NumPy arrays as motions. Vertices are read frame by frame.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/try.h"
#include "io/array_names.h"
#include "io/bytes.h"
#include "io/npz_array.h"
#include "io/npz_parts.h"
#include "io/readers.h"

namespace foldproof::io {
namespace {

constexpr const char* kNameArrays = "save arrays named 'faces' and 'vertices'";

class ArrayMotion final : public Motion {
 public:
  /// `archive`: what `vertices` is in, if it is in one.
  ArrayMotion(std::string name, std::unique_ptr<NpyArray> vertices, Archive archive)
      : name_(std::move(name)), archive_(std::move(archive)), vertices_(std::move(vertices)) {}

  Result<void> open(NpyArray& faces) {
    FOLDPROOF_TRY(check_vertices());
    return read_faces(faces);
  }
  void set_parts(ObjectParts parts) { parts_ = std::move(parts); }

  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  const ObjectParts& parts() const override { return parts_; }
  Index frame_count() const override { return frames_; }

  Result<void> read_frame(Index k, std::span<double> out) override {
    FOLDPROOF_TRY(check_request(*this, k, out));
    const NpyHeader& header = vertices_->header();
    buffer_.resize(out.size() * header.item_bytes);
    FOLDPROOF_TRY(vertices_->read_at(k * std::uint64_t{buffer_.size()}, buffer_));
    const char* bytes = buffer_.data();
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = header.item_bytes == 8 ? load<double>(bytes + 8 * i, header.order)
                                      : static_cast<double>(load<float>(bytes + 4 * i, header.order));
    }
    return check_finite(fmt::format("{}, frame {}", vertices_->where(), k), out);
  }

 private:
  Result<void> check_vertices() {
    const NpyHeader& header = vertices_->header();
    if (header.kind != 'f' || header.item_bytes < 4) {
      return fail(ErrorCode::UnsupportedFormat, vertices_->where(), "is not float32 or float64",
                  "save vertices.astype('float64')");
    }
    const auto& shape = header.shape;
    if ((shape.size() != 2 && shape.size() != 3) || shape.back() != 3) {
      return fail(ErrorCode::InvalidFile, vertices_->where(), "is not of shape frames x n x 3 (or n x 3)",
                  "reshape it before saving");
    }
    const std::uint64_t frames = shape.size() == 3 ? shape[0] : 1;
    vertex_count_ = shape[shape.size() - 2];
    if (vertex_count_ > kMaxVertices || frames >= kNoIndex) {
      return fail(ErrorCode::LimitExceeded, vertices_->where(), "has too many vertices or frames",
                  "split the motion");
    }
    frames_ = static_cast<Index>(frames);
    return {};
  }

  Result<void> read_faces(NpyArray& faces) {
    const NpyHeader& header = faces.header();
    if (!faces.is_integer()) {
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
  std::unique_ptr<NpyArray> vertices_;
  std::uint64_t vertex_count_ = 0;
  Index frames_ = 0;
  Topology topology_;
  ObjectParts parts_;
  std::vector<char> buffer_;
};

/// The array of the archive with one of these names, in any case; the first name of the list that is there.
std::string find_name(zip_t* archive, std::span<const std::string_view> names) {
  std::map<std::string, std::string> members;  // in lower case, and as they are
  for (zip_int64_t i = 0; i < zip_get_num_entries(archive, 0); ++i) {
    const char* member = zip_get_name(archive, static_cast<zip_uint64_t>(i), 0);
    const std::string path = member ? member : "";
    if (extension_of(path) != ".npy") continue;
    const std::string name = path.substr(0, path.size() - 4);
    std::string lower = name;
    std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
    members.emplace(std::move(lower), name);
  }
  for (const std::string_view name : names) {
    if (const auto found = members.find(std::string(name)); found != members.end()) return found->second;
  }
  return std::string(names.front());
}

}  // namespace

Result<std::unique_ptr<Motion>> open_npz(const std::string& path, const ReadProgress& progress) {
  std::uint64_t bytes = 0;
  auto archive = FOLDPROOF_TRY(open_archive(path, bytes));
  zip_t* zip = archive.get();
  NpzArray faces;
  auto vertices = std::make_unique<NpzArray>();
  FOLDPROOF_TRY(faces.open(zip, path, bytes, find_name(zip, kFaceNames), kNameArrays));
  FOLDPROOF_TRY(vertices->open(zip, path, bytes, find_name(zip, kVertexNames), kNameArrays));
  NpzArray& frames = *vertices;
  auto motion = std::make_unique<ArrayMotion>(path, std::move(vertices), std::move(archive));
  FOLDPROOF_TRY(motion->open(faces));
  motion->set_parts(FOLDPROOF_TRY(npz_parts(zip, path, bytes, motion->topology().triangles().size())));
  FOLDPROOF_TRY(frames.unpack(progress));
  return motion;
}

Result<std::unique_ptr<Motion>> open_npy(const std::string& one, const std::string& other) {
  auto vertices = std::make_unique<NpyFile>(), faces = std::make_unique<NpyFile>();
  FOLDPROOF_TRY(vertices->open(one));
  FOLDPROOF_TRY(faces->open(other));
  if (vertices->is_integer()) std::swap(vertices, faces);
  const std::string name = vertices->where();
  auto motion = std::make_unique<ArrayMotion>(name, std::move(vertices), nullptr);
  FOLDPROOF_TRY(motion->open(*faces));
  return motion;
}

}  // namespace foldproof::io
