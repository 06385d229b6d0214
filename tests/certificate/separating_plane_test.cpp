// plane_separates against exact arithmetic.
#include "certificate/separating_plane.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "certificate/contacts.h"
#include "certificate/patches.h"

namespace foldproof::testing {
namespace {

struct Cloud {
  std::vector<Index> a, b;
  Step step;
};

// Two point clouds about `distance` apart, with a common motion and motions of their own.
Cloud random_cloud(double size, double distance, Rng& rng) {
  std::vector<Vec3> x0, x1;
  std::vector<Index> ids[2];
  const Vec3 axis = random_direction(rng), offset = random_vector(rng, -0.2, 0.2);
  const int kind = static_cast<int>(rng() % 3);
  for (int side = 0; side < 2; ++side) {
    const std::size_t count = 1 + rng() % 20;
    const Vec3 center = offset + (side - 0.5) * (distance + size) * axis;
    const Vec3 motion = random_vector(rng, 0, 0.4) * (kind == 1 ? 1 : 0.1);
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3 p = size * random_vector(rng, 0, 0.5);
      ids[side].push_back(static_cast<Index>(x0.size()));
      x0.push_back(center + p);
      x1.push_back(center + motion + p + 0.2 * size * random_direction(rng));
    }
  }
  if (kind == 2) x1 = moved(x1, uniform(rng, 0, 2), 0.1, rng);
  fit_into_frame(x0, x1);
  return {ids[0], ids[1], Step(std::move(x0), std::move(x1))};
}

// Convex hulls come within a gap exactly when some of their features do. This samples triangles and edges
// between any of their points.
std::string find_contact_of_hulls(const Cloud& cloud, double gap) {
  const auto &x0 = cloud.step.x0, &x1 = cloud.step.x1;
  const auto at = [](const std::vector<Index>& ids, std::size_t i) { return ids[i % ids.size()]; };
  CcdSettings settings;
  settings.thickness = gap;
  Rng rng(5);
  const auto comes_near = [&](const FeaturePair& pair) {
    const FourPoints from = points_of(pair, x0), to = points_of(pair, x1);
    const CcdResult r = pair.kind == oracle::Kind::VertexFace ? vertex_face_ccd(from, to, settings)
                                                              : edge_edge_ccd(from, to, settings);
    return r.answer != Answer::Separated && comes_within(pair, x0, x1, gap);
  };
  for (int k = 0; k < 60; ++k) {
    const bool swap = rng() % 2;
    const auto &s = swap ? cloud.b : cloud.a, &t = swap ? cloud.a : cloud.b;
    const auto id = [&](const std::vector<Index>& ids) { return static_cast<std::uint16_t>(at(ids, rng())); };
    if (comes_near({oracle::Kind::VertexFace, {id(s), id(t), id(t), id(t)}}) ||
        comes_near({oracle::Kind::EdgeEdge, {id(s), id(s), id(t), id(t)}}))
      return fmt::format("features of the hulls come within {}", gap);
  }
  return {};
}

// Whether the hulls meet at a time. Exact, for positions rounded to double.
bool hulls_meet_at(const Cloud& cloud, double t) {
  std::vector<Vec3> p, q;
  const auto at = [&](Index v) { return Vec3((1 - t) * cloud.step.x0[v] + t * cloud.step.x1[v]); };
  for (const Index v : cloud.a) p.push_back(at(v));
  for (const Index v : cloud.b) q.push_back(at(v));
  // Of few points, as the time of the exact test grows with the fourth power of their number.
  if (p.size() > 5) p.resize(5);
  if (q.size() > 5) q.resize(5);
  return oracle::hulls_intersect(p, q);
}

TEST(PlaneSeparates, WhatIsSeparatedStaysFartherApartThanTheGap) {
  Rng rng(51);
  int passes = 0, tries = 0, contacts = 0;
  for (const double size : {0.3, 0.05, 1e-3}) {
    for (const double gap : {0.0, 1e-5, 1e-3, 0.1}) {
      HalfPass control(0.1);
      for (int k = 0; k < 60; ++k, ++tries) {
        // Nearer after every success.
        const double distance = gap + size * (1 - control.size());
        const Cloud cloud = random_cloud(size, distance, rng);
        const bool separated =
            plane_separates(cloud.step.vertices, cloud.a, cloud.step.vertices, cloud.b, gap);
        control.record(separated);
        const std::string contact = find_contact_of_hulls(cloud, gap);
        if (!separated) {
          contacts += !contact.empty();
          continue;
        }
        ++passes;
        ASSERT_EQ(contact, "") << "size " << size;
        if (k % 4 != 0) continue;
        for (const double t : {0.0, 0.5, 1.0}) ASSERT_FALSE(hulls_meet_at(cloud, t));
      }
    }
  }
  EXPECT_GT(passes, 0.3 * tries);
  EXPECT_LT(passes, 0.7 * tries);
  EXPECT_GT(contacts, 50);
}

// Flat clouds that lie on each other and slide: few normals separate them, and one is found from anywhere.
TEST(PlaneSeparates, FindsAPlaneBetweenFlatClouds) {
  Rng rng(54);
  for (int k = 0; k < 500; ++k) {
    constexpr double kThickness = 0.003, kGap = 1.9 * kThickness;
    std::vector<Vec3> x0, x1;
    std::vector<Index> ids[2];
    const Vec3 axis = random_direction(rng), other = random_direction(rng);
    const Vec3 motion = random_vector(rng, 0, 0.3);
    for (int side = 0; side < 2; ++side) {
      const Vec3 slide = random_vector(rng, 0, 0.2);
      for (int i = 0; i < 16; ++i) {
        const auto above = [&](Vec3 p) {  // the plane between both
          return p + axis * ((side == 0 ? 1 : -1) * kThickness * uniform(rng, 1, 2) - axis.dot(p));
        };
        const Vec3 p = random_vector(rng, 0, 0.3);
        ids[side].push_back(static_cast<Index>(x0.size()));
        x0.push_back(above(p));
        x1.push_back(above(p + slide) + motion);
      }
    }
    const Step step(std::move(x0), std::move(x1));
    for (PlaneNormal normal : {PlaneNormal{}, PlaneNormal{static_cast<float>(other.x()), 0.1f, 0.2f}}) {
      ASSERT_TRUE(plane_separates(step.vertices, ids[0], step.vertices, ids[1], kGap, &normal)) << k;
    }
  }
}

// Clouds with a common point are not separated, even with a gap of zero.
TEST(PlaneSeparates, TouchingCloudsAreNotSeparated) {
  Rng rng(52);
  for (int k = 0; k < 500; ++k) {
    Cloud cloud = random_cloud(0.2, 0.05, rng);
    const Index a = cloud.a[rng() % cloud.a.size()], b = cloud.b[rng() % cloud.b.size()];
    auto x0 = cloud.step.x0, x1 = cloud.step.x1;
    (rng() % 2 ? x0 : x1)[b] = (rng() % 2 ? x0 : x1)[a];
    x0[b] = x0[a];
    const Step step(x0, x1);
    ASSERT_FALSE(plane_separates(step.vertices, cloud.a, step.vertices, cloud.b, 0));
  }
}

// Coordinates near the smallest numbers: products and lengths underflow.
TEST(PlaneSeparates, UnderflowSeparatesNothing) {
  Rng rng(53);
  for (int k = 0; k < 20000; ++k) {
    const double size = log_uniform(rng, 1e-45, 5e-7);
    std::vector<Vec3> x0, x1;
    for (int v = 0; v < 4; ++v) {
      Vec3 p = size * random_direction(rng), q = size * random_direction(rng);
      for (int axis = 0; axis < 3; ++axis) {
        if (rng() % 3 == 0) p[axis] = 0;
        if (rng() % 3 == 0) q[axis] = rng() % 2 ? p[axis] : 0;
      }
      x0.push_back(p);
      x1.push_back(q);
    }
    const Step step(x0, x1);
    const std::vector<Index> a{0, 1}, b{2, 3};
    ASSERT_FALSE(plane_separates(step.vertices, a, step.vertices, b, 0)) << size;
  }
}

// The given normal is returned where it still separates. No given normal changes the answer.
TEST(PlaneSeparates, TriesTheGivenNormal) {
  Rng rng(77);
  int found = 0, kept = 0, changed = 0;
  for (int k = 0; k < 400; ++k) {
    const double distance = uniform(rng, -0.05, 0.2), size = uniform(rng, 0.05, 0.4);
    const Cloud cloud = random_cloud(size, distance, rng);
    const auto separates = [&](PlaneNormal& normal) {
      return plane_separates(cloud.step.vertices, cloud.a, cloud.step.vertices, cloud.b, 0, &normal);
    };
    PlaneNormal normal{};
    const bool plain = separates(normal);
    EXPECT_EQ(plain, normal != PlaneNormal{});
    found += plain;
    const PlaneNormal first = normal;
    kept += plain && separates(normal) && normal == first;
    // The search finds a normal regardless of a useless one.
    for (const PlaneNormal& useless :
         {PlaneNormal{NAN, 1, 0}, PlaneNormal{INFINITY, 0, 0}, PlaneNormal{1e-20f, 0, 0},
          PlaneNormal{-first[0], -first[1], -first[2]}}) {
      PlaneNormal given = useless;
      changed += separates(given) != plain;
    }
  }
  EXPECT_GT(found, 100);
  EXPECT_LT(found, 390);
  EXPECT_EQ(kept, found);
  EXPECT_EQ(changed, 0);
}

}  // namespace
}  // namespace foldproof::testing
