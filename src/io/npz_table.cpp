#include "io/npz_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "base/try.h"
#include "io/bytes.h"
#include "io/npy.h"

namespace foldproof::io {
namespace {

std::uint64_t bytes_of(const NpzTable::Column& column) {
  std::uint64_t bytes = column.item_bytes;
  for (const std::uint64_t n : column.row_shape) bytes *= n;
  return bytes;
}

Result<void> write_names(ZipWriter& zip, const std::string& array, std::span<const char* const> names) {
  std::size_t longest = 1;
  for (const char* name : names) longest = std::max(longest, std::string_view(name).size());
  const std::array<std::uint64_t, 1> shape{names.size()};
  const std::string header = npy_header(fmt::format("<U{}", longest), shape);
  std::vector<char> bytes(header.begin(), header.end());
  for (const std::string name : names) {
    for (std::size_t i = 0; i < longest; ++i)
      append(bytes, static_cast<std::uint32_t>(i < name.size() ? name[i] : 0));
  }
  FOLDPROOF_TRY(zip.begin(array + ".npy", bytes.size()));
  FOLDPROOF_TRY(zip.data(bytes));
  return zip.end();
}

}  // namespace

NpzTable::NpzTable(FileWriter file, Spool spool, std::vector<Column> columns)
    : file_(std::move(file)), spool_(std::move(spool)), columns_(std::move(columns)) {
  for (const Column& column : columns_) row_bytes_ += bytes_of(column);
}

Result<NpzTable> NpzTable::open(const std::string& path, std::vector<Column> columns) {
  auto file = FOLDPROOF_TRY(FileWriter::open(path));
  auto spool = FOLDPROOF_TRY(Spool::open(path));
  return NpzTable(std::move(file), std::move(spool), std::move(columns));
}

Result<void> NpzTable::end_row() {
  assert(row_.size() == row_bytes_);
  auto written = spool_.append(row_);
  row_.clear();
  ++rows_;
  return written;
}

Result<void> NpzTable::write_column(ZipWriter& zip, const Column& column, std::uint64_t offset) {
  std::vector<std::uint64_t> shape{rows_};
  shape.insert(shape.end(), column.row_shape.begin(), column.row_shape.end());
  const std::string header = npy_header(column.type, shape);
  std::vector<char> bytes(bytes_of(column));
  FOLDPROOF_TRY(zip.begin(column.name + ".npy", header.size() + rows_ * bytes.size()));
  FOLDPROOF_TRY(zip.data(header));
  for (std::uint64_t row = 0; row < rows_; ++row) {
    if (!spool_.read_at(row * row_bytes_ + offset, bytes)) {
      return fail(ErrorCode::FileAccess, column.name, "cannot be read back from the temporary file",
                  "check the temporary directory");
    }
    FOLDPROOF_TRY(zip.data(bytes));
  }
  return zip.end();
}

Result<void> NpzTable::commit(const std::string& array, std::span<const char* const> names) {
  ZipWriter zip(file_);
  std::uint64_t offset = 0;
  for (const Column& column : columns_) {
    FOLDPROOF_TRY(write_column(zip, column, offset));
    offset += bytes_of(column);
  }
  FOLDPROOF_TRY(write_names(zip, array, names));
  FOLDPROOF_TRY(zip.finish());
  return file_.commit();
}

}  // namespace foldproof::io
