/// Files and their names as the operating system has them. Text of a name is UTF-8; errors are the system's.
/// The bodies are in posix/ and windows/: nothing else in the project asks which system it is on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace foldproof::system {

/// Descriptors.
inline constexpr int kStandardOutput = 1, kStandardError = 2;

/// Identifies a file on a disk, independent of its name.
using FileId = std::pair<std::uint64_t, std::uint64_t>;

enum class FileKind : std::uint8_t { File, Directory, Other };

struct FileStatus {
  FileKind kind = FileKind::Other;
  std::uint64_t size = 0;     ///< Bytes.
  std::int64_t modified = 0;  ///< Nanoseconds since 1970.
  FileId id{};
};

/// Of what a link refers to. None: nothing is there, or it cannot be examined.
std::optional<FileStatus> status_of(const std::filesystem::path& path);

/// An open file, which is closed with this. No other program inherits it.
class File {
 public:
  enum class Mode : std::uint8_t {
    Read,    ///< Does not wait for who writes a pipe.
    Create,  ///< To write what is not there yet.
    Write,   ///< What is there already, such as a pipe or a terminal.
    Append,  ///< To read, and to write at the end; created where there is none.
  };

  /// None.
  File() = default;
  static File open(const std::filesystem::path& path, Mode mode, std::error_code& code);
  /// What is open already.
  static File duplicate(int descriptor, std::error_code& code);
  /// To read and write; closing deletes it.
  static File temporary(std::error_code& code);
  File(File&& other) noexcept : handle_(std::exchange(other.handle_, kNone)) {}
  File& operator=(File&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~File() { [[maybe_unused]] const std::error_code ignored = close(); }

  explicit operator bool() const { return handle_ != kNone; }

  /// Fills `out` with the bytes from `offset`. Returns how many there are: fewer at the end of the file.
  std::size_t read_at(std::uint64_t offset, std::span<char> out, std::error_code& code) const;
  std::error_code write(std::span<const char> bytes);
  std::error_code write_at(std::uint64_t offset, std::span<const char> bytes);
  std::error_code truncate(std::uint64_t size);
  std::optional<FileStatus> status() const;
  /// False: another program has locked it. True also where the file system has no locks.
  bool lock();
  std::error_code close();

 private:
  static constexpr std::intptr_t kNone = -1;

  std::intptr_t handle_ = kNone;
};

/// Gives a file or directory another name, also that of a file that is there, which is lost.
std::error_code rename(const std::filesystem::path& from, const std::filesystem::path& to);

/// Whether a file may take the name of one that is open.
bool can_replace_open_files();

/// Whether a file may be written, or files into a directory, as far as the system says.
bool may_write(const std::filesystem::path& path);

/// A number that no other running program has.
std::uint64_t process_number();

/// The number of a path like /dev/fd/1; -1: it is none.
int descriptor_named(const std::filesystem::path& path);

/// Whether a descriptor is open on the regular file of this path.
bool is_open_on(int descriptor, const std::filesystem::path& path);

/// Why no file can have a path's names; empty: it can.
std::string problem_of_name(const std::filesystem::path& path);

/// What separates the names in a path.
std::string_view separators();

/// A directory that cannot be listed.
struct ListError {
  std::string directory;
  std::error_code code;
};

/// What matches a pattern with "*", "?" and "[...]", in no order. Leaves out what is in directories that
/// cannot be listed; with `error` it stops at the first, unless that is not there.
std::vector<std::string> glob(const std::string& pattern, ListError* error = nullptr);

/// Whether a path matches such a pattern. A name that begins with "." only matches one that does, too.
bool matches(const std::string& pattern, const std::string& path);

}  // namespace foldproof::system
