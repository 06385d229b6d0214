// Batches of pairs give the same answers as single pairs, which narrow_properties.cpp compares with the
// oracle.
#include "ccd/conservative_advancement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "oracle/families.h"
#include "oracle/one_target.h"

namespace foldproof {
namespace {

using oracle::Case;
using oracle::Kind;
using oracle::Rng;

// All families; some pairs are so large or small that they are rescaled.
std::vector<Case> some_cases(Kind kind, int rounds) {
  std::vector<Case> cases;
  Rng rng(21);
  for (int i = 0; i < rounds; ++i) {
    for (const oracle::Family& family : oracle::families()) {
      Case& c = cases.emplace_back(family.make(kind, rng));
      if (rng() % 8 != 0) continue;
      const double scale = std::ldexp(1.0, rng() % 2 ? 200 : -200);
      for (FourPoints* x : {&c.x0, &c.x1}) {
        for (Vec3& p : *x) p *= scale;
      }
    }
  }
  return cases;
}

CcdResult alone(Kind kind, const Case& c, const CcdSettings& settings) {
  return (kind == Kind::EdgeEdge ? edge_edge_ccd : vertex_face_ccd)(c.x0, c.x1, settings);
}

// Batches of every size from one to eight.
std::vector<CcdResult> in_batches(Kind kind, const std::vector<Case>& cases, const CcdSettings& settings) {
  std::vector<CcdResult> results(cases.size());
  ConservativeAdvancement advancement(kind == Kind::EdgeEdge, settings);
  std::array<std::size_t, 8> pair_of_lane{};
  const auto iterate = [&] {
    for (unsigned done = advancement.iterate(); done != 0; done &= done - 1)
      results[pair_of_lane[__builtin_ctz(done)]] = advancement.result(__builtin_ctz(done));
  };
  PairBatch batch{};
  for (std::size_t first = 0, round = 0; first < cases.size(); ++round) {
    const std::size_t count = std::min<std::size_t>(1 + round % 8, cases.size() - first);
    for (std::size_t k = 0; k < count; ++k)
      batch.set(static_cast<int>(k), cases[first + k].x0, cases[first + k].x1);
    for (unsigned left = advancement.load(batch, static_cast<int>(count)); left != 0; left &= left - 1) {
      while (advancement.full()) iterate();
      const int k = __builtin_ctz(left);
      pair_of_lane[advancement.start(k, settings.latest)] = first + k;
    }
    first += count;
  }
  while (advancement.busy()) iterate();
  return results;
}

TEST(ConservativeAdvancement, LanesAnswerLikeSinglePairs) {
  for (const Kind kind : {Kind::VertexFace, Kind::EdgeEdge}) {
    const std::vector<Case> cases = some_cases(kind, 100);
    for (int variant = 0; variant < 4; ++variant) {
      CcdSettings settings;
      if (variant == 1) settings.latest = 0.5;
      if (variant == 2) settings.thickness = 0.01;
      if (variant == 3) settings.max_iterations = 3;
      const std::vector<CcdResult> results = in_batches(kind, cases, settings);
      int hits = 0, separated = 0;
      for (std::size_t i = 0; i < cases.size(); ++i) {
        const CcdResult expected = alone(kind, cases[i], settings);
        ASSERT_EQ(results[i].answer, expected.answer) << i;
        ASSERT_EQ(results[i].toi, expected.toi) << i;
        hits += expected.answer == Answer::Hit;
        separated += expected.answer == Answer::Separated;
      }
      EXPECT_GT(hits, cases.size() / 8);
      EXPECT_GT(separated, cases.size() / 8);
    }
  }
}

// A search for the earliest contact lowers the latest time to that of a contact; others at the same time are
// found all the same.
TEST(ConservativeAdvancement, AContactAtTheLatestTimeIsFound) {
  for (const Kind kind : {Kind::VertexFace, Kind::EdgeEdge}) {
    const std::vector<Case> cases = some_cases(kind, 100);
    int later_than_the_start = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      CcdSettings settings;
      const CcdResult found = alone(kind, cases[i], settings);
      if (found.answer != Answer::Hit) continue;
      settings.latest = found.toi;
      const CcdResult again = alone(kind, cases[i], settings);
      ASSERT_EQ(again.answer, Answer::Hit) << i;
      ASSERT_EQ(again.toi, found.toi) << i;
      if (found.toi == 0) continue;
      ++later_than_the_start;
      settings.latest = std::nextafter(found.toi, 0.0);
      ASSERT_EQ(alone(kind, cases[i], settings).answer, Answer::Separated) << i;
    }
    EXPECT_GT(later_than_the_start, cases.size() / 8);
  }
}

TEST(ConservativeAdvancement, AllInstructionSetsAgree) {
  const auto answers = [] {
    std::vector<std::pair<Answer, double>> all;
    for (const Kind kind : {Kind::VertexFace, Kind::EdgeEdge}) {
      for (const double thickness : {0.0, 0.01}) {
        CcdSettings settings;
        settings.thickness = thickness;
        for (const CcdResult& r : in_batches(kind, some_cases(kind, 40), settings))
          all.emplace_back(r.answer, r.toi);
      }
    }
    return all;
  };
  testing::expect_all_targets_agree(answers);
}

}  // namespace
}  // namespace foldproof
