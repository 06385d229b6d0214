/// A table of strings, aligned for a terminal or written as Markdown.
#pragma once

#include <string>
#include <vector>

namespace foldproof::bench {

struct Table {
  std::vector<std::string> headers;
  std::vector<std::vector<std::string>> rows;  ///< An empty row is a line across; Markdown has none.

  std::string text() const;
  std::string markdown() const;
};

}  // namespace foldproof::bench
