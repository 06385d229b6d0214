/// Expects two lists of collisions to be the same.
#pragma once

#include <gtest/gtest.h>

#include "oracle/same_answers.h"

namespace foldproof::testing {

/// The same pairs in the same order, with the same answers and bit-equal times.
template <class Collision>
void expect_same(const std::vector<Collision>& a, const std::vector<Collision>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(oracle::same_collision(a[i], b[i]))
        << "pair " << i << ", times " << a[i].toi << " and " << b[i].toi;
  }
}

inline void expect_same_collisions(const StepResult& a, const StepResult& b) {
  ASSERT_NO_FATAL_FAILURE(expect_same(a.vertex_face, b.vertex_face));
  ASSERT_NO_FATAL_FAILURE(expect_same(a.edge_edge, b.edge_edge));
}

}  // namespace foldproof::testing
