#include "page/query.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "page/page_json.h"

namespace foldproof {
namespace {

/// Adds the vertices of "A-B,C" to `out`; false if one is no number below `count`, or there are more than
/// that.
bool add_vertices(std::string_view text, Index count, std::vector<Index>& out) {
  for (const std::string_view item : split(text, ',')) {
    const auto ends = split(item, '-');
    const auto first = number_in(ends.front()), last = number_in(ends.back());
    if (ends.size() > 2 || !first || !last || *first > *last || *last >= count) return false;
    if (out.size() + (*last - *first) >= count) return false;
    for (std::uint64_t v = *first; v <= *last; ++v) out.push_back(static_cast<Index>(v));
  }
  return true;
}

}  // namespace

PageAnswer refuse(int status, const std::string& line) {
  return {status, "application/json", error_json(line)};
}

PageAnswer refuse(const Error& error) { return refuse(500, error.line()); }

PageAnswer no_number(std::string_view name) { return refuse(400, fmt::format("'{}' is no number", name)); }

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(separator, from), text.size());
    parts.push_back(text.substr(from, to - from));
    from = to + 1;
  }
  return parts;
}

std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (status != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

PageQuery query_of(std::string_view text) {
  PageQuery query;
  for (const std::string_view item : split(text, '&')) {
    const std::size_t equals = std::min(item.find('='), item.size());
    if (!item.empty()) query.emplace(item.substr(0, equals), item.substr(std::min(equals + 1, item.size())));
  }
  return query;
}

std::optional<std::uint64_t> number_of(const PageQuery& query, std::string_view name,
                                       std::uint64_t fallback) {
  const auto found = query.find(name);
  return found == query.end() ? fallback : number_in(found->second);
}

tl::expected<std::vector<std::uint64_t>, PageAnswer> numbers_of(const PageQuery& query,
                                                                std::string_view name) {
  std::vector<std::uint64_t> numbers;
  const auto named = query.find(name);
  for (const auto& text : split(named == query.end() ? std::string_view() : named->second, ',')) {
    if (text.empty()) continue;
    const auto number = number_in(text);
    if (!number) return tl::unexpected(no_number(name));
    numbers.push_back(*number);
  }
  return numbers;
}

tl::expected<std::vector<std::vector<Index>>, PageAnswer> vertices_of(const PageQuery& query,
                                                                      std::string_view name,
                                                                      std::span<const Index> counts) {
  std::vector<std::vector<Index>> vertices;
  const auto named = query.find(name);
  if (named == query.end() || named->second.empty()) return vertices;
  vertices.resize(counts.size());
  for (const std::string_view item : split(named->second, ';')) {
    const std::size_t colon = std::min(item.find(':'), item.size() - 1);
    const auto object = number_in(item.substr(0, colon));
    if (!object || *object >= counts.size() ||
        !add_vertices(item.substr(colon + 1), counts[*object], vertices[*object]))
      return tl::unexpected(refuse(400, fmt::format("'{}' are no vertices of an object: {}", name, item)));
  }
  return vertices;
}

tl::expected<Part, PageAnswer> part_of(const PageQuery& query) {
  const auto offset = number_of(query, "offset", 0), limit = number_of(query, "limit", kMaxItems);
  if (!offset) return tl::unexpected(no_number("offset"));
  if (limit && *limit <= kMaxItems) return Part{*offset, *limit};
  return tl::unexpected(refuse(400, fmt::format("'limit' is no number up to {}", kMaxItems)));
}

}  // namespace foldproof
