#include "io/spool.h"

#include <utility>

namespace foldproof::io {
namespace {

tl::unexpected<Error> spool_error(const std::string& where, const std::error_code& code) {
  return fail(ErrorCode::FileAccess, where,
              "needs a temporary file that cannot be written: " + code.message(),
              "free space in the temporary directory, or name another one in TMPDIR");
}

}  // namespace

Result<Spool> Spool::open(std::string where) {
  std::error_code code;
  system::File file = system::File::temporary(code);
  if (code) return spool_error(where, code);
  return Spool(std::move(where), std::move(file));
}

Result<void> Spool::append(std::span<const char> bytes) {
  if (const std::error_code code = file_.write(bytes)) return spool_error(where_, code);
  return {};
}

bool Spool::read_at(std::uint64_t offset, std::span<char> out) const {
  std::error_code code;
  return file_.read_at(offset, out, code) == out.size();
}

}  // namespace foldproof::io
