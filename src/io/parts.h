/// Parts of meshes, from what files say about their faces.
#pragma once

#include <string_view>

#include "foldproof/io.h"

namespace foldproof::io {

/// Parts from an id per triangle, an index into `names`. Equal names are one part, unused ones are none;
/// parts come in the order of their first triangles. Fewer than two are no parts.
ObjectParts parts_by_name(std::span<const std::string> names, std::span<const Index> of_triangle);

/// Parts from a number per triangle, named `kind` and the number: "group 7".
ObjectParts parts_by_number(std::string_view kind, std::span<const std::int64_t> of_triangle);

/// What the name of an array or a property says that its values, one per face, are: part, label, segment or
/// group, for that word, its plural, or either with "face_" before or "_id" behind. Empty: something else.
std::string_view part_kind(std::string_view name);

/// Names that hold from a triangle on until the next, in files with statements such as "g arm".
class NameRuns {
 public:
  /// `triangle`: the next one, never smaller than before. An empty name is "default".
  void begin(std::size_t triangle, std::string_view name);
  /// Triangles before the first name belong to "default".
  ObjectParts parts(std::size_t triangles) const;

 private:
  struct Run {
    std::size_t first;
    std::string name;
  };
  std::vector<Run> runs_;
};

}  // namespace foldproof::io
