/// Holds one answer of the narrow phase against the truth.
#pragma once

#include <string>

#include "oracle/oracle.h"

namespace foldproof::oracle {

/// Calls vertex_face_ccd or edge_edge_ccd.
CcdResult narrow_phase(Kind kind, const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings);

/// How far beyond the thickness a Hit may be for this pair: the tolerance of the settings, or the resolution
/// that ccd.h states if that is larger. The resolution follows the largest difference between a point of one
/// feature and a point of the other.
double allowed_tolerance(Kind kind, const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings);

struct Verdict {
  std::string complaint;  ///< What is wrong with the answer; empty when nothing is.
  bool touched = false;   ///< The truth: in contact (or within the thickness) during [0, latest].
};

/// No missed contact, none before the time of impact, and a Hit within thickness + allowed tolerance at it.
/// All three are exact; with a thickness, a contact that comes within `2^-40` of the size of the pair of
/// being none is left out.
Verdict judge(Kind kind, const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings,
              const CcdResult& result);

/// The coordinates in hexadecimal, ready to be pasted into a test.
std::string describe(Kind kind, const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings);

}  // namespace foldproof::oracle
