#include "io/npz_array.h"

#include <fmt/format.h>

#include "base/try.h"
#include "io/bytes.h"

namespace foldproof::io {

Result<Archive> open_archive(const std::string& path, std::uint64_t& bytes) {
  const auto file = FOLDPROOF_TRY(InputFile::open(path));
  bytes = file.size();
  int code = 0;
  Archive archive(zip_open(path.c_str(), ZIP_RDONLY, &code));
  if (archive) return archive;
  return fail(ErrorCode::InvalidFile, path, "is not a whole ZIP archive",
              "copy the file again, or save it with numpy.savez");
}

namespace {

Result<Spool> unpack(zip_file_t* member, std::uint64_t bytes, const std::string& where) {
  auto spool = Spool::open(where);
  if (!spool) return spool;
  std::vector<char> block(std::size_t{1} << 20);
  while (bytes > 0) {
    const zip_int64_t count = zip_fread(member, block.data(), std::min<std::uint64_t>(block.size(), bytes));
    if (count <= 0) return fail(ErrorCode::InvalidFile, where, "the packed data is damaged", kSaveArrayAgain);
    FOLDPROOF_TRY(spool->append(std::span(block).first(static_cast<std::size_t>(count))));
    bytes -= static_cast<std::uint64_t>(count);
  }
  return spool;
}

}  // namespace

Result<void> NpzArray::open(zip_t* archive, const std::string& path, std::uint64_t file_size,
                            const char* name, const char* remedy) {
  where_ = fmt::format("{}, array '{}'", path, name);
  const std::string file_name = std::string(name) + ".npy";
  const zip_int64_t index = zip_name_locate(archive, file_name.c_str(), 0);
  if (index < 0) {
    return fail(ErrorCode::InvalidFile, path, fmt::format("holds no array '{}'", name), remedy);
  }
  zip_stat_t status;
  if (zip_stat_index(archive, static_cast<zip_uint64_t>(index), 0, &status) != 0) return damaged();
  FOLDPROOF_TRY(check_sizes(status, file_size));
  stored_ = status.comp_method == ZIP_CM_STORE;
  archive_ = archive;
  index_ = static_cast<zip_uint64_t>(index);
  return read_header(status.size);
}

Result<void> NpzArray::read_at(std::uint64_t offset, std::span<char> out) {
  offset += header_.data;
  if (stored_) {
    if (zip_fseek(member_.get(), static_cast<zip_int64_t>(offset), SEEK_SET) != 0 || !read_fully(out)) {
      return damaged();
    }
    return {};
  }
  if (!spool_) {
    // Reading the header has advanced the stream, and a packed stream cannot seek back.
    member_.reset(zip_fopen_index(archive_, index_, 0));
    if (!member_) return damaged();
    const std::uint64_t bytes = header_.data + elements_ * header_.item_bytes;
    spool_ = FOLDPROOF_TRY(unpack(member_.get(), bytes, where_));
  }
  if (!spool_->read_at(offset, out)) return damaged();
  return {};
}

tl::unexpected<Error> NpzArray::damaged() const {
  return fail(ErrorCode::InvalidFile, where_, "the archive is damaged here", kSaveArrayAgain);
}

bool NpzArray::read_fully(std::span<char> out) {
  while (!out.empty()) {
    const zip_int64_t count = zip_fread(member_.get(), out.data(), out.size());
    if (count <= 0) return false;
    out = out.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

// Deflate expands a byte to at most 1032 bytes, so no larger size can be true.
Result<void> NpzArray::check_sizes(const zip_stat_t& status, std::uint64_t file_size) const {
  constexpr zip_uint64_t kNeeded = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD;
  if ((status.valid & kNeeded) != kNeeded || status.comp_size > file_size) return damaged();
  if ((status.valid & ZIP_STAT_ENCRYPTION_METHOD) && status.encryption_method != ZIP_EM_NONE) {
    return fail(ErrorCode::UnsupportedFormat, where_, "is encrypted", "save the archive without a password");
  }
  const bool stored = status.comp_method == ZIP_CM_STORE;
  if (!stored && status.comp_method != ZIP_CM_DEFLATE) {
    return fail(ErrorCode::UnsupportedFormat, where_, "is packed with a method other than deflate",
                kSaveArrayAgain);
  }
  constexpr std::uint64_t kMaxPerByte = 1032, kSlack = 64;
  const bool impossible =
      stored ? status.size != status.comp_size
             : status.size > kSlack && (status.size - kSlack) / kMaxPerByte > status.comp_size;
  if (impossible) {
    return fail(ErrorCode::InvalidFile, where_,
                fmt::format("announces {} bytes, but the file holds {} packed bytes for it", status.size,
                            status.comp_size),
                "copy or save the archive again");
  }
  return {};
}

Result<void> NpzArray::read_header(std::uint64_t size) {
  member_.reset(zip_fopen_index(archive_, index_, 0));
  std::vector<char> start(std::min<std::uint64_t>(size, kNpyHeaderLimit));
  if (!member_ || !read_fully(start)) return damaged();
  header_ = FOLDPROOF_TRY(parse_npy_header(where_, {start.data(), start.size()}));
  if (header_.fortran_order) {
    return fail(ErrorCode::UnsupportedFormat, where_, "is in Fortran order",
                "save numpy.ascontiguousarray(array)");
  }
  elements_ = (size - header_.data) / header_.item_bytes;
  std::uint64_t remaining = elements_;
  bool fits = (size - header_.data) % header_.item_bytes == 0;
  for (const std::uint64_t extent : header_.shape) {
    if (extent == 0)
      return fail(ErrorCode::InvalidFile, where_, "is empty", "save at least one triangle and one frame");
    fits = fits && remaining % extent == 0;
    remaining /= extent;
  }
  if (!fits || remaining != 1) {
    return fail(ErrorCode::InvalidFile, where_,
                fmt::format("its shape does not fit its {} bytes", size - header_.data), kSaveArrayAgain);
  }
  return {};
}

}  // namespace foldproof::io
