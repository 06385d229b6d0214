/// NumPy arrays that grow row by row, all of them together.
#pragma once

#include "io/spool.h"
#include "io/zip_writer.h"

namespace foldproof::io {

/// An NPZ of arrays with equally many rows. Rows wait in a temporary file, so that memory holds one at a
/// time; the NPZ appears on commit.
class NpzTable {
 public:
  struct Column {
    std::string name;
    std::string type;  ///< As NumPy writes it: "<u4".
    std::size_t item_bytes;
    std::vector<std::uint64_t> row_shape;  ///< Empty for a single item per row.
  };
  static Result<NpzTable> open(const std::string& path, std::vector<Column> columns);

  /// Appends to the row under way: the bytes of all columns, one after the other.
  void add(std::span<const char> bytes) { row_.insert(row_.end(), bytes.begin(), bytes.end()); }
  /// Precondition: every column got what its shape asks for.
  Result<void> end_row();

  /// Writes the file, with one more array: one row of `names`, as NumPy strings. ASCII only.
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
