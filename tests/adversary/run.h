/// Plays a case: all the ways to ask for the same answer, and the truth.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "adversary/pairs.h"

namespace foldproof::adversary {

/// Instruction sets that Highway may choose here.
std::vector<std::int64_t> targets();

/// What is wrong, empty when nothing is. Depends on the case alone.
std::string run_case(const Case& c, Tally& tally);

/// The case without the objects, triangles and steps that a complaint does not need.
Case cut_down(const Case& c);

/// A step in reduced coordinates against the same step on all vertices; the mesh and its poses are the
/// case's.
std::string check_reduced(const Case& c, Tally& tally);

/// All that a ContactChecker answers. Long-lived, made from the objects of a case as one mesh.
class SolverCheck {
 public:
  SolverCheck(const Case& c, std::mt19937_64& rng);
  ~SolverCheck();
  std::string check(const Step& step, std::mt19937_64& rng, Tally& tally);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The question that the library has to answer now, named in the message when that does not end or crashes,
/// and how many it has been asked so far.
inline const char* volatile question = "nothing";
inline std::atomic<std::uint64_t> questions_asked{0};

inline void now_asking(const char* what) {
  question = what;
  ++questions_asked;
}

}  // namespace foldproof::adversary
