/// What the program shows on a terminal.
#pragma once

#include <chrono>
#include <string>

#include "report/report.h"

namespace foldproof {

/// "foldproof: where: problem; mend" on standard error.
void print_error(const Error& error);

/// Text on standard output. That nobody reads it any more is no error.
void print_output(const std::string& text);

/// Error when standard output could not take what was printed.
Result<void> flush_output();

/// A bar with time left on standard error; silent when that is not a terminal.
class ProgressBar {
 public:
  explicit ProgressBar(bool wanted);
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `part` of the work is done, in (0,1]; `text` says it in words.
  void show(double part, const std::string& text);
  /// Takes the bar off the screen, so that other text can follow.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool wanted_, shown_ = false;
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

/// 1234567 -> "1,234,567".
std::string grouped(std::uint64_t number);

/// "1 step", "2 steps".
std::string counted(std::uint64_t number, const char* noun);

/// A name for one table cell: its end, which tells files apart, and nothing that moves the cursor.
std::string cell(std::string name);

/// The tables and the closing sentence of a finished check.
std::string summary(Motions motions, const CheckSettings& settings, const CheckTotals& totals);

/// Lists every colliding pair on standard output.
std::unique_ptr<ReportWriter> pair_listing(Motions motions);

}  // namespace foldproof
