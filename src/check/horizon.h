/// How far a search should look ahead.
#pragma once

#include "foldproof/base.h"

namespace foldproof {

/// How far vertices may deviate from a straight course in a search that looks ahead, in mean lengths of an
/// edge. With more of it charts of thin triangles fail, and candidates grow; with less, steps leave it
/// sooner.
inline constexpr double kSlack = 0x1p-10;

/// Learns from how a motion went on how many steps are worth looking ahead. Guesses for speed; depends on
/// counts only, never on clocks. Lengths are mean lengths of an edge.
class Horizon {
 public:
  /// A step was served by the last search: it ended `steps` of its steps after the search began, `off` away
  /// from the course then.
  void served(double off, double steps);
  /// A step needs a search: gives for how many steps, this one included. `off` and `steps` as above, as if
  /// the course went on; negative steps: it goes over the same course again, and says nothing. No more than
  /// `sensible`.
  Index search(double off, double steps, double sensible = 32);
  /// What that search took, in any unit.
  void took(double effort);

 private:
  double expect(double off, double steps);
  void note_bend(double off, double steps);

  double run_ = 1;                      // steps since the motion last turned
  double usual_run_ = 0;                // how many there are mostly; 0 before the first turn
  double bend_ = 0;                     // how far a step strays from the one before
  int turns_ = 0;                       // in a row
  double alone_ = 0;                    // effort of a search for one step; 0: not known
  double ahead_ = 0, ahead_steps_ = 0;  // of one for several, and how many
  double farthest_ = 4;                 // steps that may be tried
  double trust_ = 1;                    // what share of the steps it promised a search serves
  double promised_ = 1, served_ = 1;    // by the last one
};

}  // namespace foldproof
