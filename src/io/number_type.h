/// VTK's types of numbers, in its XML files and in legacy ones.
#pragma once

#include <bit>
#include <cstdint>
#include <string_view>

#include "io/bytes.h"

namespace foldproof::io {

struct NumberType {
  enum class Kind : std::uint8_t { Signed, Unsigned, Float };
  Kind kind = Kind::Signed;
  std::size_t bytes = 0;  ///< Of a number in binary data; 0: the type is not read.
};

/// By its name in XML files: "Float32".
NumberType xml_number_type(std::string_view name);
/// By its name in legacy files, in lower case: "unsigned_char".
NumberType legacy_number_type(std::string_view name);

template <class T>
T load_as(const NumberType& type, const char* bytes, std::endian order) {
  const auto get = [&]<class Stored>(Stored) { return static_cast<T>(load<Stored>(bytes, order)); };
  if (type.kind == NumberType::Kind::Float) return type.bytes == 4 ? get(float{}) : get(double{});
  const bool is_signed = type.kind == NumberType::Kind::Signed;
  switch (type.bytes) {
    case 1:
      return is_signed ? get(std::int8_t{}) : get(std::uint8_t{});
    case 2:
      return is_signed ? get(std::int16_t{}) : get(std::uint16_t{});
    case 4:
      return is_signed ? get(std::int32_t{}) : get(std::uint32_t{});
    default:
      return is_signed ? get(std::int64_t{}) : get(std::uint64_t{});
  }
}

}  // namespace foldproof::io
