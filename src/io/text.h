/// Scans text formats: lines, words and numbers, with the line number for errors.
#pragma once

#include <cstdint>
#include <string_view>

#include "foldproof/base.h"

namespace foldproof::io {

inline bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The outcome of reading a number. Missing: the line ends first.
enum class Scan : std::uint8_t { Ok, Missing, Malformed, NotFinite };

/// A position in a text. Lines end with LF, CR LF or CR.
class TextCursor {
 public:
  struct Dialect {
    /// Starts a comment to the end of the line, but not within a number ("1.#INF" is none); '\0': none.
    char comment = '#';
    bool continuation = false;  ///< A backslash at the end of a line joins the next one to it.
  };
  /// Skips the byte order mark that some editors put first.
  TextCursor(std::string_view text, Dialect dialect)
      : at_(text.data()), end_(text.data() + text.size()), dialect_(dialect) {
    if (text.starts_with("\xef\xbb\xbf")) at_ += 3;
  }

  bool at_end() const { return at_ == end_; }
  /// Counts from 1.
  std::uint64_t line() const { return line_; }
  /// The unread text.
  std::string_view remaining() const { return {at_, static_cast<std::size_t>(end_ - at_)}; }

  /// Skips blanks; true when only a comment, if anything, remains on this line.
  bool at_line_end();
  /// Moves to the start of the next line.
  void next_line();
  /// Skips empty lines and comments; false when the text ends first.
  bool skip_to_content();
  /// The next word on this line, empty at its end.
  std::string_view word();
  /// All that follows on this line, comments too, without blanks around it.
  std::string_view rest_of_line();

  Scan number(double& value);
  Scan integer(std::int64_t& value);
  /// The remainder of the word that the last leading_integer() started; may be empty.
  std::string_view tail();
  /// An integer that may start a longer word, as in "12/4/7".
  Scan leading_integer(std::int64_t& value);

 private:
  bool skip_continuation();
  bool at_comment() const { return at_ != end_ && dialect_.comment != '\0' && *at_ == dialect_.comment; }
  bool at_word_end() const;
  const char* at_;
  const char* end_;
  Dialect dialect_;
  std::uint64_t line_ = 1;
};

/// The location of a line, for errors: "walk.obj:12".
std::string at_line(const std::string& path, std::uint64_t line);

/// Why a number could not be read. `what` names the number: "a coordinate of vertex 3".
Error scan_error(Scan scan, std::string where, const std::string& what);

}  // namespace foldproof::io
