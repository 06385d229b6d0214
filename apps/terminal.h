/// Output on a terminal.
#pragma once

#include <string>

#include "base/grouped.h"
#include "report/report.h"

namespace foldproof {

/// Prints "foldproof: where: problem; remedy" on standard error.
void print_error(const Error& error);

/// Prints text on standard output.
void print_output(const std::string& text);

/// From now on print_output prints on standard error: standard output takes a report.
void print_to_standard_error();

/// Prints text on standard error.
void print_notice(const std::string& text);

/// What a color says.
enum class Tone : std::uint8_t { Good, Bad, Doubtful };

/// The text for print_output, in color on a terminal that has it, unless NO_COLOR is set (no-color.org).
std::string colored(const std::string& text, Tone tone);

/// Error: standard output could not be written. A closed pipe is no error.
Result<void> flush_output();

/// A row of a summary: what it is, and its value.
std::string row(const char* label, const std::string& value);

/// Replaces control characters.
std::string printable(std::string text);

/// Shortens a name for a table cell: the middle is left out, as beginning and end distinguish files. Replaces
/// control characters.
std::string cell(std::string name);

/// The tables and the closing sentence of a finished check.
std::string summary(Motions motions, const CheckSettings& settings, const CheckTotals& totals);

/// Lists every colliding pair on standard output.
std::unique_ptr<ReportWriter> pair_listing(Motions motions);

}  // namespace foldproof
