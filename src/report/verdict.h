/// What a check found, in a sentence for people: the same in the terminal, the page, reports and sweeps.
#pragma once

#include <variant>

#include "report/contact_groups.h"
#include "report/report.h"

namespace foldproof {

/// A text in which frames are numbers, so that programs with other frame numbers can write theirs.
class Sentence {
 public:
  Sentence& operator<<(std::string_view text);
  Sentence& frame(double time);
  std::string text() const;
  /// Texts and frames in turn.
  const std::vector<std::variant<std::string, double>>& pieces() const { return pieces_; }

 private:
  std::vector<std::variant<std::string, double>> pieces_;
};

enum class CheckVerdictKind : std::uint8_t {
  Free,     ///< Proven: nothing was found in all that was tested.
  Found,    ///< Something collides or crosses.
  Limited,  ///< Nothing was found, but that proves no freedom: steps_only, or a statistical mode.
};

struct CheckVerdict {
  CheckVerdictKind kind = CheckVerdictKind::Limited;
  /// Names come from files and may hold any character.
  Sentence sentence;
  /// What the numbers are, in a second sentence: steps, pairs, triangles. Empty where the first says it.
  std::string numbers;
  bool whole = true;  ///< Nothing was left out of the check; else the sentence names it.
};

/// The verdict of a check that has ended. It claims freedom only where everything was tested, and names what
/// was not.
CheckVerdict verdict(Motions motions, const CheckSettings& settings, const CheckTotals& totals);

/// What the contacts are, without the full stop: the worst of them, and how many more there are.
/// Precondition: there is one.
Sentence contact_sentence(Motions motions, const CheckSettings& settings, const CheckTotals& totals);

/// The name of an object without its folder and extension, where no other object has the same.
std::string short_name(Index object, Motions motions);

/// A sentence that also says what was not tested.
std::string with_untested(std::string sentence, std::span<const std::string> untested);

/// "frame 3", "frames 3 to 4, part 1 of 2".
std::string step_name(const StepIndex& index, const CheckSettings& settings);
/// "frame 0 starts with 312 crossing pairs of triangles"
std::string start_of(const CheckTotals& totals);

/// Whether a check was of one frame, in which no time passes.
inline bool is_single_frame(const CheckTotals& totals) { return totals.first_frame == totals.last_frame; }

}  // namespace foldproof
