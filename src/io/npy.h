/// The header of a NumPy array (.npy): element type, order and shape.
#pragma once

#include <bit>
#include <string_view>
#include <vector>

#include "foldproof/base.h"

namespace foldproof::io {

struct NpyHeader {
  char kind = 0;  ///< 'f' float, 'i' signed, 'u' unsigned, 'S' bytes, 'U' 32-bit characters.
  std::size_t item_bytes = 0;
  std::endian order = std::endian::little;
  bool fortran_order = false;
  std::vector<std::uint64_t> shape;
  std::uint64_t data = 0;  ///< Offset of the first element, bytes.
};

/// The largest header that is read; NumPy's take 128 bytes.
inline constexpr std::size_t kNpyHeaderLimit = 4096;

/// Parses the start of an array; `where` is for errors.
Result<NpyHeader> parse_npy_header(const std::string& where, std::string_view bytes);

/// The integer at `bytes`, of kind 'i' or 'u'. Unsigned ones of 2^63 and more become negative.
std::int64_t load_integer(const char* bytes, const NpyHeader& header);

/// A header to write, for an array in C order; `type` such as "<f8".
std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape);

}  // namespace foldproof::io
