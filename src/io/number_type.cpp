#include "io/number_type.h"

#include <algorithm>
#include <array>

namespace foldproof::io {
namespace {

using Kind = NumberType::Kind;
struct Named {
  std::string_view name;
  NumberType type;
};

NumberType find(std::span<const Named> types, std::string_view name) {
  const auto found = std::ranges::find(types, name, &Named::name);
  return found == types.end() ? NumberType() : found->type;
}

}  // namespace

NumberType xml_number_type(std::string_view name) {
  static constexpr std::array<Named, 10> kTypes{{{"Int8", {Kind::Signed, 1}},
                                                 {"UInt8", {Kind::Unsigned, 1}},
                                                 {"Int16", {Kind::Signed, 2}},
                                                 {"UInt16", {Kind::Unsigned, 2}},
                                                 {"Int32", {Kind::Signed, 4}},
                                                 {"UInt32", {Kind::Unsigned, 4}},
                                                 {"Int64", {Kind::Signed, 8}},
                                                 {"UInt64", {Kind::Unsigned, 8}},
                                                 {"Float32", {Kind::Float, 4}},
                                                 {"Float64", {Kind::Float, 8}}}};
  return find(kTypes, name);
}

// "long" is what it was where the file was written; VTK itself takes the 8 bytes of most systems. Its ids are
// of 4 bytes, whatever they are in memory.
NumberType legacy_number_type(std::string_view name) {
  static constexpr std::array<Named, 15> kTypes{{{"char", {Kind::Signed, 1}},
                                                 {"signed_char", {Kind::Signed, 1}},
                                                 {"unsigned_char", {Kind::Unsigned, 1}},
                                                 {"short", {Kind::Signed, 2}},
                                                 {"unsigned_short", {Kind::Unsigned, 2}},
                                                 {"int", {Kind::Signed, 4}},
                                                 {"unsigned_int", {Kind::Unsigned, 4}},
                                                 {"vtkidtype", {Kind::Signed, 4}},
                                                 {"long", {Kind::Signed, 8}},
                                                 {"unsigned_long", {Kind::Unsigned, 8}},
                                                 {"vtktypeint64", {Kind::Signed, 8}},
                                                 {"vtktypeuint64", {Kind::Unsigned, 8}},
                                                 {"vtktypeint32", {Kind::Signed, 4}},
                                                 {"float", {Kind::Float, 4}},
                                                 {"double", {Kind::Float, 8}}}};
  return find(kTypes, name);
}

}  // namespace foldproof::io
