// Two hundred animations of balls that pass each other, whose contacts are known: how many, when and how
// deep.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numeric>

#include "base/rounds.h"
#include "contacts/scenes.h"
#include "foldproof/eigen.h"

namespace foldproof {
namespace {

using namespace oracle;

constexpr Index kDivisions = 10;
constexpr int kSteps = 16;

// How a ball, a polyhedron, differs from the unit sphere around it.
struct Polyhedron {
  double flattening = 0;  // the largest distance of its surface from the sphere
  double angle = 0;       // from any direction to the nearest vertex or middle of an edge, at most
};

Polyhedron measured(const Mesh& ball) {
  Polyhedron out;
  double spacing = 0;  // on the triangles, from any point to the nearest vertex or middle
  for (const Triangle& t : ball.triangles) {
    Vec3 p[3];
    for (int k = 0; k < 3; ++k) p[k] = Vec3::load(&ball.positions[3 * t[k]]);
    const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]);
    out.flattening = std::max(out.flattening, 1 - std::abs(normal.normalized().dot(p[0])));
    const double circumradius =
        (p[1] - p[0]).norm() * (p[2] - p[1]).norm() * (p[0] - p[2]).norm() / (2 * normal.norm());
    spacing = std::max(spacing, circumradius / 2);
  }
  out.angle = 2 * std::asin(spacing / (2 * (1 - out.flattening)));
  return out;
}

const Polyhedron& polyhedron() {
  static const Polyhedron measures = measured(unit_sphere(kDivisions));
  return measures;
}

// Spheres of these radii are depth deep in each other; of the polyhedra in their place it is this at least.
double least_depth(double radius_a, double radius_b, double depth) {
  const double d = radius_a + radius_b - depth, kept = 1 - polyhedron().flattening;
  double least = 0;
  for (const auto& [r, other] : {std::pair(radius_a, radius_b), std::pair(radius_b, radius_a)}) {
    // The vertex or middle of one ball nearest to the center of the other.
    const double point = r * kept;
    const double away = std::sqrt(d * d + point * point - 2 * d * point * std::cos(polyhedron().angle));
    least = std::max(least, other * kept - away);
  }
  return least;
}

struct KnownContact {
  double first_time;
  std::vector<double> frames;
  double least_depth, depth;
};

struct Ball {
  double radius;
  std::vector<Vec3> centers;  // per frame
};

struct Case {
  std::vector<Ball> balls;  // 2 i + 1 passes 2 i
  std::vector<KnownContact> contacts;
};

double distance_at(const Ball& a, const Ball& b, double time) {
  const int k = std::min(int(time), kSteps - 1);
  const double share = time - k;
  return ((1 - share) * (a.centers[k] - b.centers[k]) + share * (a.centers[k + 1] - b.centers[k + 1])).norm();
}

// The contacts of two balls, from their distance; nothing where flattened balls may differ.
std::optional<std::vector<KnownContact>> contacts_of(const Ball& a, const Ball& b) {
  const double touch = a.radius + b.radius, margin = touch * polyhedron().flattening;
  std::vector<KnownContact> out;
  bool within = false;
  for (int i = 0; i <= kSteps * 64; ++i) {
    const double time = i / 64.0, d = distance_at(a, b, time);
    if (d < 1.05 * std::max(a.radius, b.radius)) return std::nullopt;  // more than a half ball is inside
    const bool is_frame = i % 64 == 0;
    if (is_frame && std::abs(d - touch) < margin) return std::nullopt;
    if (!within && d < touch) {
      out.push_back({time, {}, 0, 0});
      within = true;
    }
    if (within && d > touch) within = false;
    if (is_frame && within) {
      out.back().frames.push_back(time);
      out.back().depth = std::max(out.back().depth, touch - d);
      out.back().least_depth = least_depth(a.radius, b.radius, out.back().depth);
    }
  }
  return out;
}

// Whether the number of contacts stays the same when distances differ by the balls' flattening.
bool is_clear(const Ball& a, const Ball& b, const std::vector<KnownContact>& known) {
  const double touch = a.radius + b.radius;
  for (const double slack : {-touch * polyhedron().flattening, 0.0}) {
    bool within = false;
    std::size_t count = 0;
    for (int i = 0; i <= kSteps * 64; ++i) {
      const bool now = distance_at(a, b, i / 64.0) < touch + slack;
      count += now && !within;
      within = now;
    }
    if (count != known.size()) return false;
  }
  // Two contacts whose slices of time are neighbors are one.
  for (std::size_t i = 1; i < known.size(); ++i) {
    const double last = known[i - 1].frames.empty() ? known[i - 1].first_time : known[i - 1].frames.back();
    if (std::floor(known[i].first_time) < std::floor(last) + 3) return false;
  }
  return true;
}

Case make_case(Rng& rng) {
  std::uniform_real_distribution<double> uniform(0, 1);
  Case made;
  const int pairs = 1 + int(rng() % 4);
  while (int(made.balls.size()) < 2 * pairs) {
    const Vec3 middle(10.0 * double(made.balls.size()), 0, 0);
    Ball still{0.8 + 0.4 * uniform(rng), std::vector<Vec3>(kSteps + 1, middle)},
        moving{0.8 + 0.4 * uniform(rng), {}};
    const Vec3 way = Vec3(uniform(rng) - 0.5, uniform(rng) - 0.5, uniform(rng) - 0.5).normalized();
    const Vec3 aside = to_vec3(to_eigen(way).unitOrthogonal()) * (1.3 + 1.2 * uniform(rng));
    const double length = 3 + 2 * uniform(rng);
    const bool back = rng() % 3 == 0;
    const int fast = int(rng() % 4);  // 0: it passes in one step
    for (int k = 0; k <= kSteps; ++k) {
      double along = double(k) / kSteps;
      if (back) along = 1 - std::abs(2 * along - 1);
      if (fast == 0) along = along < 0.5 ? 0 : 1;
      moving.centers.push_back(middle + aside + (2 * along - 1) * length * way);
    }
    const auto known = contacts_of(still, moving);
    if (!known || !is_clear(still, moving, *known)) continue;
    made.balls.push_back(still);
    made.balls.push_back(moving);
    made.contacts.insert(made.contacts.end(), known->begin(), known->end());
  }
  return made;
}

// The order of `of_object` and of vertices and triangles is random.
Animation animation_of(const Case& scene, Rng& rng, int objects) {
  const Mesh ball = unit_sphere(kDivisions);
  std::vector<std::size_t> order(scene.balls.size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), rng);
  std::vector<std::vector<std::size_t>> members(static_cast<std::size_t>(objects));
  for (std::size_t i = 0; i < order.size(); ++i) members[i % members.size()].push_back(order[i]);
  Animation animation;
  animation.poses.resize(kSteps + 1, std::vector<Pose>(members.size()));
  for (std::size_t object = 0; object < members.size(); ++object) {
    Mesh all;
    for (std::size_t i = 0; i < members[object].size(); ++i) all = together(all, ball);
    std::vector<Index> new_vertex(all.vertex_count);
    std::iota(new_vertex.begin(), new_vertex.end(), Index{0});
    std::shuffle(new_vertex.begin(), new_vertex.end(), rng);
    for (Triangle& t : all.triangles) {
      for (Index& v : t) v = new_vertex[v];
    }
    std::shuffle(all.triangles.begin(), all.triangles.end(), rng);
    animation.topologies.push_back(all.topology());
    for (int k = 0; k <= kSteps; ++k) {
      Pose& x = animation.poses[static_cast<std::size_t>(k)][object];
      x.resize(all.positions.size());
      for (std::size_t i = 0; i < members[object].size(); ++i) {
        const Ball& member = scene.balls[members[object][i]];
        const Pose at = placed(ball, member.radius, member.centers[static_cast<std::size_t>(k)]);
        for (Index v = 0; v < ball.vertex_count; ++v) {
          const std::size_t to = new_vertex[i * ball.vertex_count + v];
          for (std::size_t c = 0; c < 3; ++c) x[3 * to + c] = at[3 * v + c];
        }
      }
    }
  }
  return animation;
}

auto key(const Contact& contact) {
  return std::tuple(contact.first_time, contact.frames.size(), contact.pairs, contact.depth().value_or(-1));
}

std::vector<Contact> sorted_by_time(std::vector<Contact> contacts) {
  std::sort(contacts.begin(), contacts.end(),
            [](const Contact& a, const Contact& b) { return key(a) < key(b); });
  return contacts;
}

void expect_known(const std::vector<Contact>& found, std::vector<KnownContact> known) {
  std::sort(known.begin(), known.end(),
            [](const KnownContact& a, const KnownContact& b) { return a.first_time < b.first_time; });
  ASSERT_EQ(found.size(), known.size());
  std::vector<bool> taken(known.size());
  for (const Contact& contact : found) {
    std::vector<double> frames;
    for (const ContactFrame& frame : contact.frames) {
      frames.push_back(frame.time);
      EXPECT_TRUE(frame.closed);
    }
    const auto matches = [&](std::size_t i) {
      return !taken[i] && std::abs(known[i].first_time - contact.first_time) < 0.4 &&
             known[i].frames == frames && known[i].least_depth <= contact.depth().value_or(0) &&
             contact.depth().value_or(0) <= known[i].depth + 1e-9;
    };
    std::size_t i = 0;
    while (i < known.size() && !matches(i)) ++i;
    ASSERT_LT(i, known.size()) << "contact " << contact.number << " from " << contact.first_time << ", "
                               << frames.size() << " frames, depth " << contact.depth().value_or(-1);
    taken[i] = true;
  }
}

// One object with all balls, or as many objects as there are pairs, or one for each ball.
TEST(GeneratedCases, ContactsAreWhatIsKnown) {
  Rng rng(200);
  std::size_t contacts = 0, without_frames = 0;
  const int rounds = testing::rounds(200);
  for (int round = 0; round < rounds; ++round) {
    const Case scene = make_case(rng);
    const int balls = int(scene.balls.size()), objects = std::array{1, balls / 2, balls}[round % 3];
    const auto found = sorted_by_time(contacts_of(animation_of(scene, rng, objects)).contacts);
    ASSERT_NO_FATAL_FAILURE(expect_known(found, scene.contacts)) << "round " << round;
    contacts += found.size();
    for (const Contact& contact : found) without_frames += contact.frames.empty();
    // Another order of objects, vertices and triangles.
    const auto again = sorted_by_time(contacts_of(animation_of(scene, rng, objects)).contacts);
    ASSERT_EQ(again.size(), found.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(again[i].first_time, found[i].first_time, 1e-6);
      EXPECT_EQ(again[i].frames.size(), found[i].frames.size());
      EXPECT_EQ(again[i].pairs, found[i].pairs);
      EXPECT_NEAR(again[i].depth().value_or(-1), found[i].depth().value_or(-1), 1e-9);
    }
  }
  EXPECT_GT(contacts, std::size_t(rounds * 5 / 4));
  EXPECT_GT(without_frames, std::size_t(rounds / 10));
}

}  // namespace
}  // namespace foldproof
