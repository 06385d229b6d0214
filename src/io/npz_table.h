/// Writes NumPy arrays row by row.
#pragma once

#include "io/spool.h"
#include "io/zip_writer.h"

namespace foldproof::io {

/// An NPZ of arrays with equal numbers of rows. Rows go to a temporary file, so memory holds one at a time.
/// The NPZ appears on commit.
class NpzTable {
 public:
  struct Column {
    std::string name;
    std::string type;  ///< In NumPy's notation: "<u4".
    std::size_t item_bytes;
    std::vector<std::uint64_t> row_shape;  ///< Empty for a single item per row.
  };
  static Result<NpzTable> open(const std::string& path, std::vector<Column> columns);

  /// Appends to the current row, which is the bytes of all columns in order.
  void add(std::span<const char> bytes) { row_.insert(row_.end(), bytes.begin(), bytes.end()); }
  /// Precondition: the row has the bytes of every column.
  Result<void> end_row();

  /// Writes the file, with one more array `array`: `names` as NumPy strings. ASCII only.
  Result<void> commit(const std::string& array, std::span<const char* const> names);

 private:
  NpzTable(FileWriter file, Spool spool, std::vector<Column> columns);
  Result<void> write_column(ZipWriter& zip, const Column& column, std::uint64_t offset);

  FileWriter file_;
  Spool spool_;
  std::vector<Column> columns_;
  std::vector<char> row_;
  std::uint64_t rows_ = 0, row_bytes_ = 0;
};

}  // namespace foldproof::io
