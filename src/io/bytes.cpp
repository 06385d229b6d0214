#include "io/bytes.h"

#include <fmt/format.h>

#include <system_error>

#include "base/try.h"
#include "io/recognize.h"

namespace foldproof::io {

Result<InputFile> InputFile::open(const std::string& path) {
  InputFile input;
  input.path_ = path;
  std::error_code code;
  input.file_ = system::File::open(path, system::File::Mode::Read, code);
  if (code == std::errc::no_such_file_or_directory || code == std::errc::not_a_directory)
    return does_not_exist(path);
  if (code) {
    return fail(ErrorCode::FileAccess, path, "cannot be opened: " + code.message(),
                "check the name and the permissions");
  }
  const auto status = input.file_.status();
  if (!status)
    return fail(ErrorCode::FileAccess, path, "cannot be examined", "check the name and the permissions");
  if (status->kind != system::FileKind::File) {
    return fail(ErrorCode::FileAccess, path, "is not a regular file",
                "save the data to a file and name that");
  }
  input.status_ = *status;
  std::array<char, kRecognizedBytes> buffer;
  const auto start = std::span(buffer).first(std::min<std::uint64_t>(input.size(), buffer.size()));
  FOLDPROOF_TRY(input.read_at(0, start));
  FOLDPROOF_TRY(check_is_data(path, {start.data(), start.size()}));
  return input;
}

tl::unexpected<Error> does_not_exist(const std::string& path) {
  return fail(ErrorCode::FileAccess, path, "does not exist", "check the name");
}

Result<void> InputFile::read_at(std::uint64_t offset, std::span<char> out) const {
  std::error_code code;
  const std::size_t done = file_.read_at(offset, out, code);
  if (code)
    return fail(ErrorCode::FileAccess, path_, "cannot be read: " + code.message(), "check the disk it is on");
  if (done < out.size()) {
    return fail(ErrorCode::InvalidFile, at_byte(path_, offset + done),
                "the file ends here, but more was expected", "copy or export it again");
  }
  const auto status = file_.status();
  if (!status || status->size != status_.size || status->modified != status_.modified)
    return fail(ErrorCode::InvalidFile, path_, "has been written to since it was opened", "open it again");
  return {};
}

Result<std::vector<char>> read_file(const std::string& path, const ReadProgress& progress) {
  constexpr std::uint64_t kBlock = std::uint64_t{1} << 22;
  auto file = FOLDPROOF_TRY(InputFile::open(path));
  std::vector<char> bytes;
  bytes.reserve(file.size());
  while (bytes.size() < file.size()) {
    const std::size_t done = bytes.size();
    bytes.resize(std::min(done + kBlock, file.size()));
    FOLDPROOF_TRY(file.read_at(done, std::span(bytes).subspan(done)));
    if (progress) progress(path, bytes.size(), file.size());
  }
  return bytes;
}

Result<void> write_file(const std::string& path, std::span<const char> bytes) {
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  FOLDPROOF_TRY(file.write(bytes));
  return file.commit();
}

std::string at_byte(const std::string& path, std::uint64_t offset) {
  return fmt::format("{}, byte {}", path, offset);
}

}  // namespace foldproof::io
