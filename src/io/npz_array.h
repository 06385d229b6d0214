/// Random access to the arrays of a NumPy archive, without loading them: stored members are read in place,
/// deflated ones are unpacked once into an unnamed temporary file.
#pragma once

#include <zip.h>

#include <memory>
#include <optional>

#include "io/npy.h"
#include "io/spool.h"

namespace foldproof::io {

struct CloseArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
struct CloseMember {
  void operator()(zip_file_t* member) const { zip_fclose(member); }
};
using Archive = std::unique_ptr<zip_t, CloseArchive>;

/// `bytes` becomes the file's size. Error: the file cannot be opened or is not a complete ZIP archive.
Result<Archive> open_archive(const std::string& path, std::uint64_t& bytes);

/// One array of an archive, which must outlive it.
class NpzArray final : public NpyArray {
 public:
  /// Error: there is no such array, or its sizes contradict each other or the file. `remedy`: what to do when
  /// there is none.
  Result<void> open(zip_t* archive, const std::string& path, std::uint64_t file_size, const std::string& name,
                    const std::string& remedy);
  Result<void> read_at(std::uint64_t offset, std::span<char> out) override;
  /// Unpacks a packed array now; without this, the first read does.
  Result<void> unpack(const ReadProgress& progress = {});

 private:
  bool read_fully(std::span<char> out);
  /// Of the whole member.
  std::uint64_t bytes() const { return header().data + elements() * header().item_bytes; }

  zip_t* archive_ = nullptr;
  zip_uint64_t index_ = 0;
  bool stored_ = false;
  std::unique_ptr<zip_file_t, CloseMember> member_;
  std::optional<Spool> spool_;  // the unpacked member, once read
};

}  // namespace foldproof::io
