#include "io/array_motion.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/try.h"
#include "io/array_names.h"
#include "io/bytes.h"

namespace foldproof::io {
namespace {

/// Those of `names` that are among the usual ones, in any case.
std::vector<std::string> find_names(std::span<const std::string> names,
                                    std::span<const std::string_view> usual) {
  std::vector<std::string> found;
  for (const std::string& name : names) {
    std::string lower = name;
    std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
    if (std::ranges::find(usual, lower) != usual.end()) found.push_back(name);
  }
  if (found.empty()) found.emplace_back(usual.front());
  return found;
}

}  // namespace

ArrayNames find_arrays(std::span<const std::string> members) {
  std::vector<std::string> names;
  for (const std::string& path : members) {
    if (extension_of(path) == ".npy") names.push_back(path.substr(0, path.size() - 4));
  }
  return {find_names(names, kVertexNames), find_names(names, kFaceNames)};
}

tl::unexpected<Error> several_arrays(const std::string& path, const char* what,
                                     std::span<const std::string> names) {
  return fail(ErrorCode::InvalidFile, path,
              fmt::format("holds several arrays of {}: {}", what, fmt::join(names, ", ")),
              "save only the one that is meant");
}

Result<std::string> choose_faces(const std::string& path, const ArrayNames& names) {
  if (names.faces.size() > 1) return several_arrays(path, "faces", names.faces);
  return names.faces[0];
}

Result<void> ArrayMotion::open(NpyArray& faces) {
  FOLDPROOF_TRY(check_vertices());
  return read_faces(faces);
}

Result<void> ArrayMotion::read_frame(Index k, std::span<double> out) {
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

Result<void> ArrayMotion::check_vertices() {
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

Result<void> ArrayMotion::read_faces(NpyArray& faces) {
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

Result<std::vector<Index>> read_merged(NpyArray& array, Index vertices) {
  const NpyHeader& header = array.header();
  if (!array.is_integer() || header.shape.size() != 1 || header.shape[0] != vertices) {
    return fail(ErrorCode::InvalidFile, array.where(), "does not hold an integer for each vertex",
                "save the number of the vertex that each one is merged into");
  }
  std::vector<char> bytes(array.elements() * header.item_bytes);
  FOLDPROOF_TRY(array.read_at(0, bytes));
  std::vector<Index> merged(vertices);
  for (Index v = 0; v < vertices; ++v) {
    const std::int64_t to = load_integer(bytes.data() + v * header.item_bytes, header);
    if (to < 0 || to > v || (to < v && merged[static_cast<Index>(to)] != to)) {
      return fail(ErrorCode::InvalidFile, fmt::format("{}, vertex {}", array.where(), v),
                  "is not merged into itself or into an earlier vertex that is merged into itself",
                  "save the first vertex at its place");
    }
    merged[v] = static_cast<Index>(to);
  }
  return merged;
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
