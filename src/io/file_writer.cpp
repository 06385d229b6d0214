// Files appear whole or not at all: data goes to a temporary file beside the target, which commit renames.
#include <fmt/format.h>

#include <atomic>
#include <filesystem>
#include <system_error>

#include "base/try.h"
#include "foldproof/io.h"
#include "io/named_files.h"
#include "io/write_error.h"
#include "system/file.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferBytes = std::size_t{1} << 18;

using system::File;

/// A name in the target's directory that no other writer of this or another process uses.
std::string temporary_name(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  return (target.parent_path() / fmt::format(".{}.{}-{}.part", target.filename().string().substr(0, 200),
                                             system::process_number(), counter.fetch_add(1)))
      .string();
}

}  // namespace

struct FileWriter::State {
  std::string path;        // as the caller gave it
  std::string target;      // with symbolic links resolved, so that a link stays a link
  std::string temporary;   // empty for pipes, terminals and what is open already, which are written directly
  bool may_close = false;  // standard output: whoever reads it may have seen enough
  File file;
  std::error_code failure;
  std::vector<char> buffer;

  ~State() {
    std::error_code ignored = file.close();
    if (!temporary.empty()) fs::remove(temporary, ignored);
  }

  Result<void> write(std::span<const char> bytes) {
    failure = file.write(bytes);
    if (failure == std::errc::broken_pipe && may_close) failure.clear();
    if (failure) return io::write_error(path, failure);
    return {};
  }

  Result<void> flush() {
    if (failure) return io::write_error(path, failure);
    auto done = write(buffer);
    buffer.clear();
    return done;
  }
};

FileWriter::FileWriter(FileWriter&&) noexcept = default;
FileWriter& FileWriter::operator=(FileWriter&&) noexcept = default;
FileWriter::~FileWriter() = default;

Result<FileWriter> FileWriter::open(const std::string& path) {
  FileWriter writer;
  writer.state_ = std::make_unique<State>();
  State& state = *writer.state_;
  if (path == "-") {
    state.path = "standard output";
    state.may_close = true;
    state.file = File::duplicate(system::kStandardOutput, state.failure);
    if (state.failure) return io::write_error(state.path, state.failure);
    return writer;
  }
  state.path = path;
  const io::WriteTarget target = io::write_target(path);
  if (target.descriptor >= 0) {
    state.may_close = target.descriptor == system::kStandardOutput;
    state.file = File::duplicate(target.descriptor, state.failure);
    if (state.failure) return io::write_error(path, state.failure);
    return writer;
  }
  FOLDPROOF_TRY(io::require_possible_name(path, path));
  std::error_code status;
  state.target = target.file.string();
  if (fs::is_directory(state.target, status))
    return io::write_error(path, std::make_error_code(std::errc::is_a_directory));
  const bool special = fs::exists(state.target, status) && !fs::is_regular_file(state.target, status);
  const std::string name = special ? path : temporary_name(state.target);
  state.file = File::open(name, special ? File::Mode::Write : File::Mode::Create, state.failure);
  if (state.failure) return io::write_error(path, state.failure);
  if (!special) state.temporary = name;
  state.buffer.reserve(kBufferBytes);
  return writer;
}

Result<void> FileWriter::write(std::span<const char> bytes) {
  State& state = *state_;
  if (state.buffer.size() + bytes.size() > kBufferBytes) {
    FOLDPROOF_TRY(state.flush());
  }
  if (bytes.size() < kBufferBytes) {
    state.buffer.insert(state.buffer.end(), bytes.begin(), bytes.end());
    return {};
  }
  return state.write(bytes);
}

Result<void> FileWriter::rewrite(std::uint64_t offset, std::span<const char> bytes) {
  State& state = *state_;
  FOLDPROOF_TRY(state.flush());
  state.failure = state.temporary.empty() ? std::make_error_code(std::errc::invalid_seek)
                                          : state.file.write_at(offset, bytes);
  if (state.failure) return io::write_error(state.path, state.failure);
  return {};
}

Result<void> FileWriter::commit() {
  State& state = *state_;
  FOLDPROOF_TRY(state.flush());
  std::error_code code = state.file.close();
  if (code) return io::write_error(state.path, code);
  if (state.temporary.empty()) return {};
  code = system::rename(state.temporary, state.target);
  if (code) return io::write_error(state.path, code);
  state.temporary.clear();
  return {};
}

}  // namespace foldproof
