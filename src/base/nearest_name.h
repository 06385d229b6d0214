/// What a mistyped name was meant to be.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace foldproof::inline internal {

/// The name that differs from `word` in the fewest letters (inserted, omitted, replaced, or two neighbors
/// exchanged), the first of several. None, if more than a third of the letters differ, and more than one.
std::optional<std::string> nearest_name(std::string_view word, std::span<const std::string> names);

}  // namespace foldproof::inline internal
