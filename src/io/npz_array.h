/// Random access to the arrays of a NumPy archive, without loading them: stored members are read in place,
/// deflated ones are unpacked once into an unnamed temporary file.
#pragma once

#include <zip.h>

#include <memory>
#include <optional>

#include "io/npy.h"
#include "io/spool.h"

namespace foldproof::io {

inline constexpr const char* kSaveArrayAgain = "save the archive with numpy.savez again";

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
class NpzArray {
 public:
  const NpyHeader& header() const { return header_; }
  std::uint64_t elements() const { return elements_; }
  const std::string& where() const { return where_; }

  /// Error: there is no such array, or its sizes contradict each other or the file. `remedy`: what to do when
  /// there is none.
  Result<void> open(zip_t* archive, const std::string& path, std::uint64_t file_size, const char* name,
                    const char* remedy);
  /// Fills `out` with bytes of the elements, from byte `offset` on.
  Result<void> read_at(std::uint64_t offset, std::span<char> out);

 private:
  tl::unexpected<Error> damaged() const;
  bool read_fully(std::span<char> out);
  Result<void> check_sizes(const zip_stat_t& status, std::uint64_t file_size) const;
  Result<void> read_header(std::uint64_t size);

  std::string where_;
  NpyHeader header_;
  std::uint64_t elements_ = 0;
  zip_t* archive_ = nullptr;
  zip_uint64_t index_ = 0;
  bool stored_ = false;
  std::unique_ptr<zip_file_t, CloseMember> member_;
  std::optional<Spool> spool_;  // the unpacked member, once read
};

}  // namespace foldproof::io
