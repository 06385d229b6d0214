// Step sizes by islands: proven free together, and no vertex is stopped by what it does not meet.

#include <gtest/gtest.h>

#include "soups.h"

namespace foldproof::oracle {
namespace {

ContactChecker checker_of(const Soup& soup) {
  return ContactChecker(std::make_shared<const CollisionMesh>(mesh_of(soup, {})));
}

// Points on a line along x, each with where it goes.
Soup beads(std::initializer_list<std::array<double, 2>> ways) {
  Soup soup;
  for (const auto& [from, to] : ways) {
    soup.x0.insert(soup.x0.end(), {from, 0, 0});
    soup.x1.insert(soup.x1.end(), {to, 0, 0});
  }
  return soup;
}

std::vector<double> shares_of(const Soup& soup, double min_distance = 0) {
  ContactChecker checker = checker_of(soup);
  std::vector<double> shares;
  const auto done = checker.collision_free_step_sizes(soup.x0, soup.x1, shares, min_distance);
  EXPECT_TRUE(done.has_value()) << done.error().line();
  std::vector<double> end(soup.x0.size());
  step_towards(soup.x0, soup.x1, shares, end);
  const bool stays = std::ranges::count(shares, 0.0) > 0;
  EXPECT_TRUE(stays || checker_of(soup).is_step_collision_free(soup.x0, end, min_distance).is_yes());
  return shares;
}

TEST(Islands, OneContactDoesNotStopTheOthers) {
  const auto shares = shares_of(beads({{0, 1}, {2, 1}, {10, 11}}));
  EXPECT_NEAR(shares[0], 0.8, 1e-6);
  EXPECT_EQ(shares[1], shares[0]);
  EXPECT_EQ(shares[2], 1);
  EXPECT_EQ(shares_of(beads({{0, 1}, {2, 3}})), std::vector<double>(2, 1.0));
}

// The third follows the second, which the first stops.
TEST(Islands, ThoseThatMeetWhereOneStopsBecomeOne) {
  const auto shares = shares_of(beads({{0, 1}, {2, 1}, {4, 1.5}, {20, 19}}));
  EXPECT_NEAR(shares[0], 0.8, 1e-6);
  EXPECT_EQ(shares[1], shares[0]);
  EXPECT_EQ(shares[2], 1) << "at 1.5, the second ends at 1.2";
  const auto far = shares_of(beads({{0, 1}, {2, 1}, {4, 1.1}, {20, 19}}));
  EXPECT_EQ(far[2], far[0]);
  EXPECT_EQ(far[3], 1);
}

TEST(Islands, WhatRestsJoinsNothing) {
  // One lies on the floor already, two fall on it from different heights.
  Soup soup;
  soup.x0 = {-9, 0, -9, 9, 0, -9, 0, 0, 9, 0, 0, 0, 1, 1, 0, 2, 2, 0};
  soup.x1 = soup.x0;
  for (const Index v : {3u, 4u, 5u}) soup.x1[3 * v + 1] = -2;
  soup.faces = {{0, 1, 2}};
  const auto shares = shares_of(soup);
  EXPECT_EQ(shares[3], 0);
  EXPECT_NEAR(shares[4], 0.8 / 3, 1e-6);
  EXPECT_NEAR(shares[5], 0.8 / 2, 1e-6);
}

TEST(Islands, LongQueuesGoOneShare) {
  Soup soup;
  for (int k = 0; k < 80; ++k) {
    soup.x0.insert(soup.x0.end(), {2.0 * k, 0, 0});
    soup.x1.insert(soup.x1.end(), {k == 0 ? 1.0 : 2.0 * k - 1.9, 0, 0});
  }
  soup.x0.insert(soup.x0.end(), {0, 5, 0});
  soup.x1.insert(soup.x1.end(), {0, 5, 0});
  const auto shares = shares_of(soup);
  for (int k = 0; k < 80; ++k) EXPECT_GT(shares[k], 0.3) << k;
}

TEST(Islands, WhatIsTooCloseAtTheStartStays) {
  const auto shares = shares_of(beads({{0, 1}, {0, 2}, {5, 6}}));
  EXPECT_EQ(shares, (std::vector<double>{0, 0, 1}));
  EXPECT_EQ(shares_of(beads({{0, 1}, {0.5, 2}, {5, 6}}), 0.6), (std::vector<double>{0, 0, 1}));
}

TEST(Islands, SoupsAreFreeAndNoSlowerThanWithOneShare) {
  int islands = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Rng rng(seed);
    const Soup soup = random_soup(rng, 4, 6, 6, 0.08, 0x1p-40);
    ContactChecker checker = checker_of(soup);
    const double min_distance = seed % 2 == 0 ? 0 : 1e-3;
    const StepSize one = checker.collision_free_step_size(soup.x0, soup.x1, min_distance).value();
    if (one.share == 0) continue;
    const auto shares = shares_of(soup, min_distance);  // and free, by a checker of its own
    for (const double share : shares) EXPECT_GE(share, one.share * (1 - 1e-9));
    islands += one.share < 1 && std::ranges::count(shares, 1.0) > 0;
  }
  EXPECT_GT(islands, 10);
}

TEST(Islands, BadInputIsAnError) {
  const Soup soup = beads({{0, 1}, {2, 1}});
  ContactChecker checker = checker_of(soup);
  std::vector<double> shares;
  const std::vector<double> fewer(3);
  EXPECT_FALSE(checker.collision_free_step_sizes(fewer, soup.x1, shares).has_value());
  EXPECT_FALSE(checker.collision_free_step_sizes(soup.x0, soup.x1, shares, -1).has_value());
  checker.settings().conservative_rescaling = 0;
  EXPECT_FALSE(checker.collision_free_step_sizes(soup.x0, soup.x1, shares).has_value());
}

}  // namespace
}  // namespace foldproof::oracle
