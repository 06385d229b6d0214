// NumPy archives. The vertices stay in the file: stored members are sought, deflated ones are unpacked once
// into a temporary file that has no name.
#include <fmt/format.h>
#include <zip.h>

#include <optional>

#include "io/bytes.h"
#include "io/npy.h"
#include "io/readers.h"
#include "io/spool.h"

namespace foldproof::io {
namespace {

constexpr const char* kSaveAgain = "save the archive with numpy.savez again";

struct CloseArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
struct CloseMember {
  void operator()(zip_file_t* member) const { zip_fclose(member); }
};
using Archive = std::unique_ptr<zip_t, CloseArchive>;
using OpenMember = std::unique_ptr<zip_file_t, CloseMember>;

Result<Spool> unpack(zip_file_t* member, std::uint64_t bytes, const std::string& where) {
  auto spool = Spool::open(where);
  if (!spool) return spool;
  std::vector<char> block(std::size_t{1} << 20);
  while (bytes > 0) {
    const zip_int64_t count = zip_fread(member, block.data(), std::min<std::uint64_t>(block.size(), bytes));
    if (count <= 0) return fail(where, "the packed data is damaged", kSaveAgain);
    const auto written = spool->append(std::span(block).first(static_cast<std::size_t>(count)));
    if (!written) return tl::unexpected(written.error());
    bytes -= static_cast<std::uint64_t>(count);
  }
  return spool;
}

/// One array of the archive.
class Array {
 public:
  const NpyHeader& header() const { return header_; }
  std::uint64_t elements() const { return elements_; }
  const std::string& where() const { return where_; }

  Result<void> open(zip_t* archive, const std::string& path, std::uint64_t file_size, const char* name) {
    where_ = fmt::format("{}, array '{}'", path, name);
    const std::string file_name = std::string(name) + ".npy";
    const zip_int64_t index = zip_name_locate(archive, file_name.c_str(), 0);
    if (index < 0) {
      return fail(path, fmt::format("holds no array '{}'", name), "save arrays named 'faces' and 'vertices'");
    }
    zip_stat_t status;
    if (zip_stat_index(archive, static_cast<zip_uint64_t>(index), 0, &status) != 0) return damaged();
    if (auto checked = check_sizes(status, file_size); !checked) return checked;
    stored_ = status.comp_method == ZIP_CM_STORE;
    archive_ = archive;
    index_ = static_cast<zip_uint64_t>(index);
    return read_header(status.size);
  }

  /// Fills `out` with the bytes from `offset` of the elements.
  Result<void> read_at(std::uint64_t offset, std::span<char> out) {
    offset += header_.data;
    if (stored_) {
      if (zip_fseek(member_.get(), static_cast<zip_int64_t>(offset), SEEK_SET) != 0 || !read_fully(out)) {
        return damaged();
      }
      return {};
    }
    if (!spool_) {
      // The header has been read from it, and a packed stream does not go back.
      member_.reset(zip_fopen_index(archive_, index_, 0));
      if (!member_) return damaged();
      const std::uint64_t bytes = header_.data + elements_ * header_.item_bytes;
      auto spool = unpack(member_.get(), bytes, where_);
      if (!spool) return tl::unexpected(spool.error());
      spool_ = std::move(*spool);
    }
    if (!spool_->read_at(offset, out)) return damaged();
    return {};
  }

 private:
  tl::unexpected<Error> damaged() const { return fail(where_, "the archive is damaged here", kSaveAgain); }

  bool read_fully(std::span<char> out) {
    while (!out.empty()) {
      const zip_int64_t count = zip_fread(member_.get(), out.data(), out.size());
      if (count <= 0) return false;
      out = out.subspan(static_cast<std::size_t>(count));
    }
    return true;
  }

  // A packed byte gives at most 1032 bytes, so a size beyond that is a lie, whatever the archive says.
  Result<void> check_sizes(const zip_stat_t& status, std::uint64_t file_size) const {
    constexpr zip_uint64_t kNeeded = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD;
    if ((status.valid & kNeeded) != kNeeded || status.comp_size > file_size) return damaged();
    if ((status.valid & ZIP_STAT_ENCRYPTION_METHOD) && status.encryption_method != ZIP_EM_NONE) {
      return fail(where_, "is encrypted", "save the archive without a password");
    }
    const bool stored = status.comp_method == ZIP_CM_STORE;
    if (!stored && status.comp_method != ZIP_CM_DEFLATE) {
      return fail(where_, "is packed with a method other than deflate", kSaveAgain);
    }
    constexpr std::uint64_t kMostPerByte = 1032, kSlack = 64;
    const bool lies = stored
                          ? status.size != status.comp_size
                          : status.size > kSlack && (status.size - kSlack) / kMostPerByte > status.comp_size;
    if (lies) {
      return fail(where_,
                  fmt::format("announces {} bytes, but the file holds {} packed bytes for it", status.size,
                              status.comp_size),
                  "copy or save the archive again");
    }
    return {};
  }

  Result<void> read_header(std::uint64_t size) {
    member_.reset(zip_fopen_index(archive_, index_, 0));
    std::vector<char> start(std::min<std::uint64_t>(size, kNpyHeaderLimit));
    if (!member_ || !read_fully(start)) return damaged();
    auto header = parse_npy_header(where_, {start.data(), start.size()});
    if (!header) return tl::unexpected(header.error());
    header_ = std::move(*header);
    if (header_.fortran_order) {
      return fail(where_, "is in Fortran order", "save numpy.ascontiguousarray(array)");
    }
    elements_ = (size - header_.data) / header_.item_bytes;
    std::uint64_t left = elements_;
    bool fits = (size - header_.data) % header_.item_bytes == 0;
    for (const std::uint64_t extent : header_.shape) {
      if (extent == 0) return fail(where_, "is empty", "save at least one triangle and one frame");
      fits = fits && left % extent == 0;
      left /= extent;
    }
    if (!fits || left != 1) {
      return fail(where_, fmt::format("its shape does not fit its {} bytes", size - header_.data),
                  kSaveAgain);
    }
    return {};
  }

  std::string where_;
  NpyHeader header_;
  std::uint64_t elements_ = 0;
  zip_t* archive_ = nullptr;
  zip_uint64_t index_ = 0;
  bool stored_ = false;
  OpenMember member_;
  std::optional<Spool> spool_;  // what a packed member holds, once it was needed
};

/// The id at `bytes`, or kNoIndex when it is none.
Index load_index(const char* bytes, const NpyHeader& h) {
  const auto narrow = [](auto value) {
    return value >= 0 && static_cast<std::uint64_t>(value) < kNoIndex ? static_cast<Index>(value) : kNoIndex;
  };
  const bool is_signed = h.kind == 'i';
  switch (h.item_bytes) {
    case 1:
      return is_signed ? narrow(load<std::int8_t>(bytes, h.order))
                       : narrow(load<std::uint8_t>(bytes, h.order));
    case 2:
      return is_signed ? narrow(load<std::int16_t>(bytes, h.order))
                       : narrow(load<std::uint16_t>(bytes, h.order));
    case 4:
      return is_signed ? narrow(load<std::int32_t>(bytes, h.order))
                       : narrow(load<std::uint32_t>(bytes, h.order));
    default:
      return is_signed ? narrow(load<std::int64_t>(bytes, h.order))
                       : narrow(load<std::uint64_t>(bytes, h.order));
  }
}

class NpzMotion final : public Motion {
 public:
  explicit NpzMotion(std::string path) : name_(std::move(path)) {}

  Result<void> open() {
    const auto file = InputFile::open(name_);
    if (!file) return tl::unexpected(file.error());
    int code = 0;
    archive_.reset(zip_open(name_.c_str(), ZIP_RDONLY, &code));
    if (!archive_) {
      return fail(name_, "is not a whole ZIP archive", "copy the file again, or save it with numpy.savez");
    }
    Array faces;
    if (auto opened = faces.open(archive_.get(), name_, file->size(), "faces"); !opened) return opened;
    if (auto opened = vertices_.open(archive_.get(), name_, file->size(), "vertices"); !opened) return opened;
    if (auto checked = check_vertices(); !checked) return checked;
    return read_faces(faces);
  }

  const std::string& name() const override { return name_; }
  const Topology& topology() const override { return topology_; }
  Index frame_count() const override { return frames_; }

  Result<void> read_frame(Index k, std::span<double> out) override {
    if (auto checked = check_request(*this, k, out); !checked) return checked;
    const NpyHeader& header = vertices_.header();
    buffer_.resize(out.size() * header.item_bytes);
    if (auto read = vertices_.read_at(k * std::uint64_t{buffer_.size()}, buffer_); !read) return read;
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
      return fail(vertices_.where(), "is not float32 or float64", "save vertices.astype('float64')");
    }
    const auto& shape = header.shape;
    if ((shape.size() != 2 && shape.size() != 3) || shape.back() != 3) {
      return fail(vertices_.where(), "is not of shape frames x n x 3 (or n x 3)", "reshape it before saving");
    }
    const std::uint64_t frames = shape.size() == 3 ? shape[0] : 1;
    vertex_count_ = shape[shape.size() - 2];
    if (vertex_count_ > kMaxVertices || frames >= kNoIndex) {
      return fail(vertices_.where(), "has too many vertices or frames", "split the motion");
    }
    frames_ = static_cast<Index>(frames);
    return {};
  }

  Result<void> read_faces(Array& faces) {
    const NpyHeader& header = faces.header();
    if (header.kind != 'i' && header.kind != 'u') {
      return fail(faces.where(), "does not hold integers", "save faces.astype('int32')");
    }
    if (header.shape.size() != 2 || header.shape[1] != 3 || header.shape[0] > kMaxTriangles) {
      return fail(faces.where(), "is not of shape triangles x 3", "triangulate the faces and reshape them");
    }
    std::vector<char> bytes(faces.elements() * header.item_bytes);
    if (auto read = faces.read_at(0, bytes); !read) return read;
    std::vector<Triangle> triangles(header.shape[0]);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Index v = load_index(bytes.data() + (3 * i + k) * header.item_bytes, header);
        if (v >= vertex_count_) {
          return fail(fmt::format("{}, face {}", faces.where(), i),
                      fmt::format("refers to a vertex that does not exist: there are {}, counting from 0",
                                  vertex_count_),
                      kSaveAgain);
        }
        triangles[i][k] = v;
      }
    }
    auto topology = Topology::make(static_cast<Index>(vertex_count_), std::move(triangles));
    if (!topology) return tl::unexpected(topology.error());
    topology_ = std::move(*topology);
    return {};
  }

  std::string name_;
  Archive archive_;  // before the array, which reads from it
  Array vertices_;
  std::uint64_t vertex_count_ = 0;
  Index frames_ = 0;
  Topology topology_;
  std::vector<char> buffer_;
};

}  // namespace

Result<std::unique_ptr<Motion>> open_npz(const std::string& path) {
  auto motion = std::make_unique<NpzMotion>(path);
  if (auto opened = motion->open(); !opened) return tl::unexpected(opened.error());
  return motion;
}

}  // namespace foldproof::io
