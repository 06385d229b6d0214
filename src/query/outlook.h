/// How far a search should look ahead.
#pragma once

#include <array>

#include "foldproof/base.h"

namespace foldproof {

/// Learns from how a motion went on how many steps are worth looking ahead, and how much room vertices need
/// to stray from a straight course. Guesses for speed; depends on counts only, never on clocks. Lengths are
/// mean lengths of an edge.
class Outlook {
 public:
  struct Choice {
    Index steps = 1;  ///< The one at hand included.
    double room = 0;  ///< 0 when only the step at hand is looked at.
  };

  /// A step was served by the last search: it ended `steps` of its steps after the search began, `off` away
  /// from the course then.
  void served(double off, double steps);
  /// A step needs a search. `off` and `steps` as above, as if the course went on; negative steps: it is not
  /// known, or the step goes elsewhere.
  Choice search(double off, double steps);
  /// What that search took, in any unit.
  void took(double effort);

 private:
  // 0: the step alone. From 1 on: looks ahead, with twice the room each.
  static constexpr int kKinds = 6;
  static double room_of(int kind);
  double steps_of(int kind, double expected) const;
  void settle();
  double expect(double off, double steps);
  void note_bend(double off, double steps);

  double run_ = 1;                        // steps since the motion last turned
  double usual_run_ = 0;                  // how many there are mostly; 0 before the first turn
  double bend_ = 0;                       // how far a step strays from the one before
  int turns_ = 0;                         // in a row
  std::array<double, kKinds> efforts_{};  // of a search of each kind; 0: not known
  double trust_ = 1;                      // what share of the steps it promised a search serves
  int kind_ = 0;                          // of the last search
  double promised_ = 1, served_ = 1;      // by it
};

}  // namespace foldproof
