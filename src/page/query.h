/// Reads the parameters of requests.
#pragma once

#include <optional>
#include <span>

#include "foldproof/base.h"
#include "page/page.h"

namespace foldproof {

/// An answer with {"error": line}.
PageAnswer refuse(int status, const std::string& line);
PageAnswer refuse(const Error& error);
PageAnswer no_number(std::string_view name);

std::vector<std::string_view> split(std::string_view text, char separator);
std::optional<std::uint64_t> number_in(std::string_view text);

/// The parameters of "a=1&b=2", which is not decoded.
PageQuery query_of(std::string_view text);

/// A numeric parameter, `fallback` if it is absent; nothing if it is not a number.
std::optional<std::uint64_t> number_of(const PageQuery& query, std::string_view name, std::uint64_t fallback);

/// Numbers with commas between; none if the parameter is absent.
tl::expected<std::vector<std::uint64_t>, PageAnswer> numbers_of(const PageQuery& query,
                                                                std::string_view name);

/// Per object, the vertices of "I:A-B,C;J:...": numbers, and ranges with both ends, of objects I and J.
/// `counts`: how many vertices each object has. Empty if the parameter is absent.
tl::expected<std::vector<std::vector<Index>>, PageAnswer> vertices_of(const PageQuery& query,
                                                                      std::string_view name,
                                                                      std::span<const Index> counts);

/// The requested part of a list.
struct Part {
  std::uint64_t offset = 0, limit = 0;
};
inline constexpr std::uint64_t kMaxItems = 1000;  ///< In one answer.
tl::expected<Part, PageAnswer> part_of(const PageQuery& query);

}  // namespace foldproof
