/// The header of a NumPy array (.npy): element type, order and shape.
#pragma once

#include <optional>
#include <string_view>

#include "io/bytes.h"

namespace foldproof::io {

struct NpyHeader {
  char kind = 0;  ///< 'f' float, 'i' signed, 'u' unsigned, 'S' bytes, 'U' 32-bit characters.
  std::size_t item_bytes = 0;
  std::endian order = std::endian::little;
  bool fortran_order = false;
  std::vector<std::uint64_t> shape;
  std::uint64_t data = 0;  ///< Offset of the first element, bytes.
};

inline constexpr const char* kSaveArrayAgain = "save the array with NumPy again";

/// The largest header that is read; NumPy's take 128 bytes.
inline constexpr std::size_t kNpyHeaderLimit = 4096;

/// Parses the start of an array; `where` is for errors.
Result<NpyHeader> parse_npy_header(const std::string& where, std::string_view bytes);

/// The integer at `bytes`, of kind 'i' or 'u'. Unsigned ones of 2^63 and more become negative.
std::int64_t load_integer(const char* bytes, const NpyHeader& header);

/// An array in a file, whose elements are read in place.
class NpyArray {
 public:
  NpyArray() = default;
  NpyArray(const NpyArray&) = delete;
  NpyArray& operator=(const NpyArray&) = delete;
  virtual ~NpyArray() = default;

  const NpyHeader& header() const { return header_; }
  std::uint64_t elements() const { return elements_; }
  const std::string& where() const { return where_; }
  bool is_integer() const { return header_.kind == 'i' || header_.kind == 'u'; }
  /// Fills `out` with bytes of the elements, from byte `offset` on.
  virtual Result<void> read_at(std::uint64_t offset, std::span<char> out) = 0;

 protected:
  /// Parses the header. `start`: the first kNpyHeaderLimit bytes of the array's `size`. Error: it is not a
  /// header, or its shape contradicts the size; no elements, or in Fortran order.
  Result<void> parse(std::string where, std::string_view start, std::uint64_t size);

 private:
  std::string where_;
  NpyHeader header_;
  std::uint64_t elements_ = 0;
};

/// A .npy file.
class NpyFile final : public NpyArray {
 public:
  Result<void> open(const std::string& path);
  Result<void> read_at(std::uint64_t offset, std::span<char> out) override {
    return file_->read_at(header().data + offset, out);
  }

 private:
  std::optional<InputFile> file_;
};

/// A header to write, for an array in C order; `type` such as "<f8".
std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape);

}  // namespace foldproof::io
