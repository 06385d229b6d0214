/// A glTF or GLB file as it stands: JSON, buffers, and accessors whose ranges have been checked.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_set>
#include <vector>

#include "io/bytes.h"

namespace foldproof::io {

/// Numbers in a buffer: `count` elements of `components` each. The bytes belong to the document.
struct GltfValues {
  const char* bytes = nullptr;  ///< Null: all zero.
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
  int component_type = 0;
  int components = 0;
  bool normalized = false;

  double get(std::uint64_t i, int component) const;
  /// Of an unsigned integer type.
  std::uint32_t integer(std::uint64_t i, int component) const;
};

/// Values, some of which may be replaced.
struct GltfAccessor {
  GltfValues base;
  GltfValues replaced;  ///< Which elements, ascending.
  GltfValues values;    ///< What stands there instead.

  std::uint64_t count() const { return base.count; }
  double get(std::uint64_t i, int component) const;
  bool is_unsigned() const;
};

/// Keeps the first complaint and answers every later question with something harmless, so that the code that
/// walks through a file needs to look for errors only at the end of each section.
class GltfDocument {
 public:
  using Json = nlohmann::json;

  static Result<GltfDocument> read(const std::string& path);

  const std::string& path() const { return path_; }
  const std::optional<Error>& error() const { return error_; }
  /// `place` is a path in the JSON: "accessors[3]".
  void complain(const std::string& place, std::string problem, std::string mend = "export the file again");

  /// A list at the top level; empty when it is absent.
  const Json& list(const char* key) { return list(json_, key, "file"); }
  const Json& list(const Json& object, const char* key, const std::string& place);
  /// A number >= 0 below 2^40, which leaves room to multiply.
  std::optional<std::uint64_t> optional_count(const Json& object, const char* key, const std::string& place);
  std::uint64_t count(const Json& object, const char* key, const std::string& place);
  /// An index into `list(of)`.
  std::optional<std::size_t> optional_index(const Json& object, const char* key, const char* of,
                                            const std::string& place);
  std::size_t index(const Json& object, const char* key, const char* of, const std::string& place);
  /// An element of a list of indices into `list(of)`.
  std::size_t checked_index(const Json& value, const char* of, const std::string& place);
  /// `out.size()` finite numbers; false, and `out` as it was, when the key is absent.
  bool numbers(const Json& object, const char* key, std::span<double> out, const std::string& place);
  std::string text(const Json& object, const char* key, const std::string& fallback);

  /// The accessor at `index`, which must have this type ("VEC3").
  GltfAccessor accessor(std::size_t index, std::string_view type, const std::string& place);

  /// To be called before `count` values of an accessor are looked at. Any number of accessors may show the
  /// same bytes, so the size of the file does not limit how many there are; this does. False, with a
  /// complaint, when they are too many.
  bool may_read(std::uint64_t count, const std::string& place);

  const Json& json() const { return json_; }

 private:
  using Buffer = std::shared_ptr<const std::vector<char>>;
  Result<void> split_glb(std::vector<char> file);
  Result<void> parse_json(std::string_view text, std::uint64_t offset);
  void check_extensions();
  void load_buffers();
  Result<Buffer> load_uri(const std::string& uri, const std::string& place);
  std::span<const char> view(std::size_t index, std::uint64_t& stride);
  GltfValues values(const Json& source, const GltfValues& shape, const std::string& place);

  std::string path_;
  Json json_;
  std::optional<std::vector<char>> chunk_;  // GLB's own buffer
  std::vector<Buffer> buffers_;
  std::map<std::string, Buffer> files_;        // that buffers name; many may name the same
  std::unordered_set<std::size_t> ascending_;  // sparse accessors that have been looked through
  std::uint64_t values_read_ = 0;
  std::optional<Error> error_;
};

}  // namespace foldproof::io
