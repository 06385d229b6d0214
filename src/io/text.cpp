#include "io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/read_double.h"

namespace foldproof::io {
namespace {

bool is_line_end(char c) { return c == '\n' || c == '\r'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

// Tells underflow from overflow, for which std::from_chars returns the same error.
bool is_below_one(std::string_view number) {
  std::int64_t magnitude = 0;  // decimal position of the first nonzero digit, positive before the point
  bool seen = false, point = false;
  std::size_t i = 0;
  for (; i < number.size() && (is_digit(number[i]) || number[i] == '.' || number[i] == '-'); ++i) {
    if (number[i] == '.') point = true;
    if (!is_digit(number[i])) continue;
    const bool leading_zero = !seen && number[i] == '0';
    if (!point && !leading_zero) ++magnitude;
    if (point && leading_zero) --magnitude;
    seen = seen || !leading_zero;
  }
  std::int64_t exponent = 0;
  if (i < number.size()) {
    const char* digits = number.data() + i + 1;
    if (digits < number.data() + number.size() && *digits == '+') ++digits;
    const auto [_, status] = std::from_chars(digits, number.data() + number.size(), exponent);
    if (status == std::errc::result_out_of_range) return *digits == '-';
  }
  return exponent < -magnitude;
}

}  // namespace

bool TextCursor::skip_continuation() {
  if (!dialect_.continuation || end_ - at_ < 2 || *at_ != '\\' || !is_line_end(at_[1])) return false;
  const bool pair = end_ - at_ >= 3 && at_[1] == '\r' && at_[2] == '\n';
  at_ += pair ? 3 : 2;
  ++line_;
  return true;
}

bool TextCursor::at_line_end() {
  while (at_ != end_ && (is_blank(*at_) || *at_ == '\\')) {
    if (is_blank(*at_)) {
      ++at_;
    } else if (!skip_continuation()) {
      break;
    }
  }
  return at_ == end_ || is_line_end(*at_) || at_comment();
}

void TextCursor::next_line() {
  at_ = std::find_if(at_, end_, is_line_end);
  if (at_ == end_) return;
  at_ += end_ - at_ >= 2 && at_[0] == '\r' && at_[1] == '\n' ? 2 : 1;
  ++line_;
}

bool TextCursor::skip_to_content() {
  while (at_line_end()) {
    if (at_ == end_) return false;
    next_line();
  }
  return true;
}

bool TextCursor::at_word_end() const {
  return at_ == end_ || is_blank(*at_) || is_line_end(*at_) || at_comment() ||
         (dialect_.continuation && *at_ == '\\' && end_ - at_ >= 2 && is_line_end(at_[1]));
}

std::string_view TextCursor::word() { return at_line_end() ? std::string_view{} : tail(); }

std::string_view TextCursor::rest_of_line() {
  while (at_ != end_ && is_blank(*at_)) ++at_;
  const char* begin = at_;
  at_ = std::find_if(at_, end_, is_line_end);
  std::string_view text(begin, static_cast<std::size_t>(at_ - begin));
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view TextCursor::tail() {
  const char* begin = at_;
  while (!at_word_end()) ++at_;
  return {begin, static_cast<std::size_t>(at_ - begin)};
}

Scan TextCursor::number(double& value) {
  if (at_line_end()) return Scan::Missing;
  if (*at_ == '+' && end_ - at_ >= 2 && at_[1] != '-') ++at_;
  const auto [stop, status] = read_double(at_, end_, value);
  if (status == std::errc::invalid_argument) return Scan::Malformed;
  const std::string_view text(at_, static_cast<std::size_t>(stop - at_));
  at_ = stop;
  if (!at_word_end() || at_comment()) return Scan::Malformed;
  if (status == std::errc::result_out_of_range) {
    if (!is_below_one(text)) return Scan::NotFinite;
    value = 0;
  }
  return std::isfinite(value) ? Scan::Ok : Scan::NotFinite;
}

Scan TextCursor::leading_integer(std::int64_t& value) {
  if (at_line_end()) return Scan::Missing;
  if (*at_ == '+' && end_ - at_ >= 2 && at_[1] != '-') ++at_;
  const auto [stop, status] = std::from_chars(at_, end_, value);
  if (status != std::errc()) return Scan::Malformed;
  at_ = stop;
  return at_comment() ? Scan::Malformed : Scan::Ok;
}

Scan TextCursor::integer(std::int64_t& value) {
  const Scan scan = leading_integer(value);
  return scan == Scan::Ok && !at_word_end() ? Scan::Malformed : scan;
}

std::string at_line(const std::string& path, std::uint64_t line) { return fmt::format("{}:{}", path, line); }

Error scan_error(Scan scan, std::string where, const std::string& what) {
  switch (scan) {
    case Scan::Missing:
      return {std::move(where), what + " is missing", "export the mesh again", ErrorCode::InvalidFile};
    case Scan::NotFinite:
      return {std::move(where), what + " is not finite",
              "export the mesh without NaN or infinite coordinates", ErrorCode::NonFinite};
    default:
      return {std::move(where), what + " is not a number", "export the mesh again", ErrorCode::InvalidFile};
  }
}

}  // namespace foldproof::io
