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

tl::unexpected<Error> damaged(const std::string& where) {
  return fail(ErrorCode::InvalidFile, where, "the archive is damaged here", kSaveArrayAgain);
}

tl::unexpected<Error> wrong_checksum(const std::string& where) {
  return fail(ErrorCode::InvalidFile, where, "its checksum is wrong", kSaveArrayAgain);
}

/// Whether a member that was read to its end has the right checksum, which libzip compares only where it
/// finds the end. True also if parts of it were skipped.
bool is_whole(zip_file_t* member) {
  char more = 0;
  return zip_fread(member, &more, 1) == 0;
}

Result<Spool> spool_of(zip_file_t* member, std::uint64_t bytes, const std::string& where,
                       const ReadProgress& progress) {
  auto spool = Spool::open(where);
  if (!spool) return spool;
  std::vector<char> block(std::size_t{1} << 20);
  for (std::uint64_t done = 0; done < bytes;) {
    const zip_int64_t count =
        zip_fread(member, block.data(), std::min<std::uint64_t>(block.size(), bytes - done));
    if (count <= 0) return fail(ErrorCode::InvalidFile, where, "the packed data is damaged", kSaveArrayAgain);
    FOLDPROOF_TRY(spool->append(std::span(block).first(static_cast<std::size_t>(count))));
    done += static_cast<std::uint64_t>(count);
    if (progress) progress(where, done, bytes);
  }
  if (!is_whole(member)) return wrong_checksum(where);
  return spool;
}

// Deflate expands a byte to at most 1032 bytes, so no larger size can be true.
Result<void> check_sizes(const std::string& where, const zip_stat_t& status, std::uint64_t file_size) {
  constexpr zip_uint64_t kNeeded = ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE | ZIP_STAT_COMP_METHOD;
  if ((status.valid & kNeeded) != kNeeded || status.comp_size > file_size) return damaged(where);
  if ((status.valid & ZIP_STAT_ENCRYPTION_METHOD) && status.encryption_method != ZIP_EM_NONE) {
    return fail(ErrorCode::UnsupportedFormat, where, "is encrypted", "save the archive without a password");
  }
  const bool stored = status.comp_method == ZIP_CM_STORE;
  if (!stored && status.comp_method != ZIP_CM_DEFLATE) {
    return fail(ErrorCode::UnsupportedFormat, where, "is packed with a method other than deflate",
                kSaveArrayAgain);
  }
  constexpr std::uint64_t kMaxPerByte = 1032, kSlack = 64;
  const bool impossible =
      stored ? status.size != status.comp_size
             : status.size > kSlack && (status.size - kSlack) / kMaxPerByte > status.comp_size;
  if (impossible) {
    return fail(ErrorCode::InvalidFile, where,
                fmt::format("announces {} bytes, but the file holds {} packed bytes for it", status.size,
                            status.comp_size),
                "copy or save the archive again");
  }
  return {};
}

}  // namespace

Result<void> NpzArray::open(zip_t* archive, const std::string& path, std::uint64_t file_size,
                            const std::string& name, const std::string& remedy) {
  const std::string where = fmt::format("{}, array '{}'", path, name);
  const zip_int64_t index = zip_name_locate(archive, (name + ".npy").c_str(), 0);
  if (index < 0) {
    return fail(ErrorCode::InvalidFile, path, fmt::format("holds no array '{}'", name), remedy);
  }
  archive_ = archive;
  index_ = static_cast<zip_uint64_t>(index);
  zip_stat_t status;
  if (zip_stat_index(archive, index_, 0, &status) != 0) return damaged(where);
  FOLDPROOF_TRY(check_sizes(where, status, file_size));
  stored_ = status.comp_method == ZIP_CM_STORE;
  member_.reset(zip_fopen_index(archive_, index_, 0));
  std::vector<char> start(std::min<std::uint64_t>(status.size, kNpyHeaderLimit));
  if (!member_ || !read_fully(start)) return damaged(where);
  return parse(where, {start.data(), start.size()}, status.size);
}

Result<void> NpzArray::read_at(std::uint64_t offset, std::span<char> out) {
  offset += header().data;
  if (stored_) {
    if (zip_fseek(member_.get(), static_cast<zip_int64_t>(offset), SEEK_SET) != 0 || !read_fully(out)) {
      return damaged(where());
    }
    const bool ends = offset + out.size() == bytes();
    return ends && !is_whole(member_.get()) ? Result<void>(wrong_checksum(where())) : Result<void>();
  }
  FOLDPROOF_TRY(unpack());
  if (!spool_->read_at(offset, out)) return damaged(where());
  return {};
}

Result<void> NpzArray::unpack(const ReadProgress& progress) {
  if (stored_ || spool_) return {};
  // Reading the header has advanced the stream, and a packed stream cannot seek back.
  member_.reset(zip_fopen_index(archive_, index_, 0));
  if (!member_) return damaged(where());
  spool_ = FOLDPROOF_TRY(spool_of(member_.get(), bytes(), where(), progress));
  return {};
}

bool NpzArray::read_fully(std::span<char> out) {
  while (!out.empty()) {
    const zip_int64_t count = zip_fread(member_.get(), out.data(), out.size());
    if (count <= 0) return false;
    out = out.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace foldproof::io
