/// Comparison of two lists of collisions.
#pragma once

#include <gtest/gtest.h>

#include <cstring>

#include "oracle/brute_force.h"

namespace foldproof::testing {

/// Expects the same pairs in the same order, with the same answers and bit-equal times.
template <class Collision>
void expect_same(const std::vector<Collision>& a, const std::vector<Collision>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(oracle::key(a[i]), oracle::key(b[i]));
    EXPECT_EQ(std::memcmp(&a[i].toi, &b[i].toi, sizeof a[i].toi), 0);
    EXPECT_EQ(a[i].answer, b[i].answer);
  }
}

}  // namespace foldproof::testing
