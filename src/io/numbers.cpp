// Tables of numbers: CSV text and single arrays of a NumPy archive.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <set>

#include "base/try.h"
#include "foldproof/io.h"
#include "io/bytes.h"
#include "io/npz_array.h"
#include "io/text.h"

namespace foldproof {
namespace {

constexpr const char* kOneRowPerLine = "write one row per line, numbers with commas between them";

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '"'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return fields;
}

io::Scan scan_number(std::string_view text, double& value) {
  io::TextCursor cursor(text, {.comment = '\0', .continuation = false});
  const io::Scan scan = cursor.number(value);
  return cursor.at_end() ? scan : io::Scan::Malformed;
}

/// Whether a field stands where a number should, even if it is not finite ("1.#IND" is NaN on old Windows).
bool is_numeric(std::string_view text) {
  double value;
  const io::Scan scan = scan_number(text, value);
  return scan == io::Scan::Ok || scan == io::Scan::NotFinite || text.find(".#") != text.npos;
}

/// What spreadsheets write where a formula failed.
bool is_formula_error(std::string_view text) {
  constexpr std::array<std::string_view, 9> kErrors{"#N/A",   "#NUM!",  "#VALUE!", "#DIV/0!", "#REF!",
                                                    "#NAME?", "#NULL!", "#SPILL!", "#CALC!"};
  return std::ranges::any_of(kErrors, [&](std::string_view error) { return text.starts_with(error); });
}

/// Whether a field may name a column: it is no number and does not stand for a missing one.
bool is_name(std::string_view text) {
  constexpr std::array<std::string_view, 8> kMissing{"null", "none", "nil", "na",
                                                     "n/a",  "<na>", "nan", "missing"};
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto is_letter = [](char c) {
    return static_cast<unsigned char>(c) >= 0x80 || (c >= 'a' && c <= 'z');
  };
  return std::ranges::any_of(lower, is_letter) && !is_numeric(text) && !is_formula_error(text) &&
         std::ranges::find(kMissing, lower) == kMissing.end();
}

class CsvReader {
 public:
  explicit CsvReader(const std::string& path) : path_(path) {}

  Result<NumberTable> read(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // the byte order mark of some spreadsheets
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      std::string_view line = text.substr(begin, end - begin);
      if (line.ends_with('\r')) line.remove_suffix(1);
      begin = end + 1;
      ++line_;
      const std::string_view content = trimmed(line);
      if (content.empty() || (content.front() == '#' && !is_formula_error(content))) continue;
      FOLDPROOF_TRY(add(fields_of(line)));
    }
    if (rows_ == 0) return fail(ErrorCode::InvalidFile, path_, "holds no numbers", kOneRowPerLine);
    table_.shape = {rows_, columns_};
    return std::move(table_);
  }

 private:
  Result<void> add(const std::vector<std::string_view>& fields) {
    const std::string where = io::at_line(path_, line_);
    if (columns_ == 0) {
      columns_ = fields.size();
      if (std::ranges::all_of(fields, is_name)) {
        table_.names.assign(fields.begin(), fields.end());
        if (std::set(fields.begin(), fields.end()).size() == columns_) return {};
        return fail(ErrorCode::InvalidFile, where, "names two columns alike", "give each its own name");
      }
    }
    if (fields.size() != columns_) {
      return fail(ErrorCode::InvalidFile, where,
                  fmt::format("has {} numbers, and the first line has {}", fields.size(), columns_),
                  kOneRowPerLine);
    }
    for (const std::string_view field : fields) {
      double value;
      if (scan_number(field, value) != io::Scan::Ok) {
        return fail(ErrorCode::InvalidFile, where, fmt::format("'{}' is not a finite number", field),
                    kOneRowPerLine);
      }
      table_.values.push_back(value);
    }
    ++rows_;
    return {};
  }

  const std::string& path_;
  NumberTable table_;
  std::uint64_t line_ = 0, rows_ = 0, columns_ = 0;
};

}  // namespace

Result<NumberTable> read_csv(const std::string& path) {
  const auto bytes = FOLDPROOF_TRY(io::read_file(path));
  return CsvReader(path).read({bytes.data(), bytes.size()});
}

Result<NumberTable> read_npz_numbers(const std::string& path, const std::string& array) {
  std::uint64_t bytes = 0;
  const auto archive = FOLDPROOF_TRY(io::open_archive(path, bytes));
  io::NpzArray numbers;
  const std::string remedy = fmt::format("save an array of that name, with numpy.savez(file, {}=...)", array);
  FOLDPROOF_TRY(numbers.open(archive.get(), path, bytes, array, remedy));
  const io::NpyHeader& header = numbers.header();
  if (header.kind != 'f' || header.item_bytes < 4) {
    return fail(ErrorCode::UnsupportedFormat, numbers.where(), "is not float32 or float64",
                "save its .astype('float64')");
  }
  std::vector<char> raw(numbers.elements() * header.item_bytes);
  FOLDPROOF_TRY(numbers.read_at(0, raw));
  NumberTable table{header.shape, {}, {}};
  table.values.reserve(numbers.elements());
  for (std::uint64_t i = 0; i < numbers.elements(); ++i) {
    const char* item = raw.data() + i * header.item_bytes;
    table.values.push_back(header.item_bytes == 8 ? io::load<double>(item, header.order)
                                                  : static_cast<double>(io::load<float>(item, header.order)));
    if (!std::isfinite(table.values.back())) {
      return fail(ErrorCode::NonFinite, numbers.where(), fmt::format("number {} is not finite", i),
                  "save finite numbers");
    }
  }
  return table;
}

Result<bool> npz_has_array(const std::string& path, const std::string& array) {
  std::uint64_t bytes = 0;
  const auto archive = FOLDPROOF_TRY(io::open_archive(path, bytes));
  return zip_name_locate(archive.get(), fmt::format("{}.npy", array).c_str(), 0) >= 0;
}

}  // namespace foldproof
