/// A glTF or GLB file: JSON, buffers, and accessors with checked ranges.
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
  bool is_unsigned() const;
};

/// Values, some of which a sparse accessor replaces.
struct GltfAccessor {
  GltfValues base;
  GltfValues replaced;  ///< Indices of the replaced elements, ascending.
  GltfValues values;    ///< Their replacements.

  std::uint64_t count() const { return base.count; }
  double get(std::uint64_t i, int component) const;
};

/// Keeps the first error; every later query returns a harmless default. So a reader needs to check for errors
/// only at the end of each section.
class GltfDocument {
 public:
  using Json = nlohmann::json;

  static Result<GltfDocument> read(const std::string& path, const ReadProgress& progress);

  const std::string& path() const { return path_; }
  const std::optional<Error>& error() const { return error_; }
  /// Keeps the error unless there is one already. `json_path`: the location in the JSON, "accessors[3]".
  void set_error(const std::string& json_path, std::string problem,
                 std::string remedy = "export the file again");

  /// A list; empty when it is absent.
  const Json& list(const char* key) { return list(json_, key, "file"); }
  const Json& list(const Json& object, const char* key, const std::string& json_path);
  /// A number in [0, 2^40), so that products of two counts and small factors do not overflow.
  std::optional<std::uint64_t> optional_count(const Json& object, const char* key,
                                              const std::string& json_path);
  std::uint64_t count(const Json& object, const char* key, const std::string& json_path);
  /// An index into `list(of)`.
  std::optional<std::size_t> optional_index(const Json& object, const char* key, const char* of,
                                            const std::string& json_path);
  std::size_t index(const Json& object, const char* key, const char* of, const std::string& json_path);
  /// An element of a list of indices into `list(of)`.
  std::size_t checked_index(const Json& value, const char* of, const std::string& json_path);
  /// Fills `out` with finite numbers; false, and `out` unchanged, when the key is absent.
  bool numbers(const Json& object, const char* key, std::span<double> out, const std::string& json_path);
  std::string text(const Json& object, const char* key, const std::string& fallback);

  /// The accessor at `index`, which must have this type ("VEC3").
  /// `user`: what refers to it, for errors.
  GltfAccessor accessor(std::size_t index, std::string_view type, const std::string& user);

  /// Call before reading `count` values of an accessor. Accessors may share bytes, so the size of the file
  /// does not limit their number; this budget does. False, with an error set, when it is exceeded.
  bool within_budget(std::uint64_t count, const std::string& json_path);

  const Json& json() const { return json_; }
  /// The bytes of buffers[i].
  std::span<const char> buffer(std::size_t i) const { return *buffers_[i]; }

 private:
  using Buffer = std::shared_ptr<const std::vector<char>>;
  Result<void> split_glb(std::vector<char> file);
  Result<void> parse_json(std::string_view text, std::uint64_t offset);
  void check_extensions();
  void load_buffers(const ReadProgress& progress);
  Result<Buffer> load_uri(const std::string& uri, const std::string& json_path, const ReadProgress& progress);
  std::span<const char> view(std::size_t index, std::uint64_t& stride);
  GltfValues values(const Json& source, const GltfValues& shape, const std::string& json_path);

  std::string path_;
  Json json_;
  std::optional<std::vector<char>> chunk_;  // GLB's own buffer
  std::vector<Buffer> buffers_;
  std::map<std::string, Buffer> files_;             // by path; several buffers may name the same file
  std::unordered_set<std::size_t> checked_sparse_;  // accessors whose sparse indices have been checked
  std::uint64_t values_read_ = 0;
  std::optional<Error> error_;
};

}  // namespace foldproof::io
