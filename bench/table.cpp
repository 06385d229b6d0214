#include "table.h"

#include <algorithm>

#include <fmt/format.h>

namespace foldproof::bench {
namespace {

std::vector<std::size_t> column_widths(const Table& table) {
  std::vector<std::size_t> widths;
  for (const std::string& header : table.headers) widths.push_back(header.size());
  for (const auto& row : table.rows)
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  return widths;
}

/// The first column to the left, figures to the right.
std::string padded(const std::string& cell, std::size_t width, bool first) {
  return first ? fmt::format("{:<{}}", cell, width) : fmt::format("{:>{}}", cell, width);
}

std::string line(const std::vector<std::string>& cells, const std::vector<std::size_t>& widths,
                 const std::string& between) {
  std::string out;
  for (std::size_t c = 0; c < cells.size(); ++c)
    out += (c ? between : "") + padded(cells[c], widths[c], c == 0);
  return out;
}

}  // namespace

std::string Table::text() const {
  const auto widths = column_widths(*this);
  std::size_t total = 2 * (widths.size() - 1);
  for (const std::size_t w : widths) total += w;
  std::string out = line(headers, widths, "  ") + "\n" + std::string(total, '-') + "\n";
  for (const auto& row : rows)
    out += (row.empty() ? std::string(total, '-') : line(row, widths, "  ")) + "\n";
  return out;
}

std::string Table::markdown() const {
  const auto widths = column_widths(*this);
  std::string out = "| " + line(headers, widths, " | ") + " |\n|";
  for (std::size_t c = 0; c < widths.size(); ++c)
    out += c == 0 ? std::string(widths[c] + 2, '-') + "|" : std::string(widths[c] + 1, '-') + ":|";
  out += "\n";
  for (const auto& row : rows)
    if (!row.empty()) out += "| " + line(row, widths, " | ") + " |\n";
  return out;
}

}  // namespace foldproof::bench
