/// VTK's XML files: their elements, and arrays in every encoding.
#pragma once

#include <pugixml.hpp>
#include <vector>

#include "io/bytes.h"

namespace foldproof::io {

/// A file whose arrays are read when they are asked for.
class VtkFile {
 public:
  /// `type`: what the file must hold, such as "PolyData". `bytes` must outlive the file.
  static Result<VtkFile> parse(const std::string& path, std::string_view bytes, const char* type);

  const std::string& path() const { return path_; }
  /// The element that has the name of the type.
  pugi::xml_node content() const { return document_.child("VTKFile").child(type_.c_str()); }
  /// A count that an attribute states; 0 when it is absent. Error: not a number below 2^32 - 1.
  Result<std::uint64_t> count(pugi::xml_node element, const char* attribute) const;

  /// The values of a DataArray, converted to double or std::int64_t. Error: it is damaged, in an encoding
  /// that is not read, or of another kind than T.
  template <class T>
  Result<std::vector<T>> values(pugi::xml_node array);

  tl::unexpected<Error> error(pugi::xml_node element, std::string problem) const;

 private:
  Result<std::vector<char>> binary(pugi::xml_node array);
  Result<std::vector<char>> unpack(pugi::xml_node array, std::string_view encoded, bool base64);

  std::string path_, type_;
  pugi::xml_document document_;
  std::string_view appended_;
  bool appended_is_base64_ = false;
  std::endian order_ = std::endian::little;
  std::size_t word_ = 4;  // bytes of a number in the header of an array
  bool compressed_ = false;
  std::uint64_t budget_ = 0;  // encoded bytes that may still be read: arrays might share them
};

}  // namespace foldproof::io
