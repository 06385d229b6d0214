// Groups of elements and what they continue, against their definition, tried for all pairs.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "base/rounds.h"
#include "contacts/joiner.h"
#include "mesh/grid.h"

namespace foldproof {
namespace {

struct Element {
  std::vector<Index> a, b;  // global ids
};

// Neighboring vertices, and each vertex with itself.
using Near = std::set<Edge>;

bool has_near(const std::vector<Index>& a, const std::vector<Index>& b, const Near& near) {
  return std::any_of(a.begin(), a.end(), [&](Index u) {
    return std::any_of(b.begin(), b.end(), [&](Index w) {
      return near.contains(Edge{std::min(u, w), std::max(u, w)});
    });
  });
}

// Whether both have a key in common, or keys whose vertices are near.
bool are_joined(const Element& e, const Element& f, const Near& first, const Near& second) {
  return (has_near(e.a, f.a, first) && has_near(e.b, f.b, second)) ||
         (has_near(e.a, f.b, first) && has_near(e.b, f.a, second));
}

class Scene {
 public:
  Near same, neighbors;

  Scene() {
    for (Index v = 0; v < surfaces_.vertex_count(); ++v) same.insert({v, v});
    for (Index object = 0; object < 2; ++object) {
      for (const auto& [u, w] : surfaces_.topology(object).edges())
        neighbors.insert({surfaces_.vertex(object, u), surfaces_.vertex(object, w)});
    }
  }

  const Surfaces& surfaces() const { return surfaces_; }

  std::vector<Element> slice() {
    std::vector<Element> elements(1 + random_() % 6);
    for (Element& e : elements) {
      do {
        const Index object = random_() % 2, other = random_() % 4 == 0 ? object : 1 - object;
        e = {feature(object), feature(other)};
      } while (has_near(e.a, e.b, same));
    }
    const auto is_before = [](const Element& e, const Element& f) { return e.a < f.a; };
    if (random_() % 2 == 0) std::sort(elements.begin(), elements.end(), is_before);
    return elements;
  }

 private:
  // Some corners of a triangle.
  std::vector<Index> feature(Index object) {
    const Triangle corners = surfaces_.corners(object, random_() % 12);
    std::vector<Index> out;
    for (const Index v : corners) {
      if (random_() % 2 == 0) out.push_back(v);
    }
    return out.empty() ? feature(object) : out;
  }

  // A fan, whose first vertex has more neighbors than are looked at one by one, and a cloth.
  static Topology fan() {
    std::vector<Triangle> triangles;
    for (Index k = 1; k < 200; ++k) triangles.push_back({0, k, k + 1});
    return Topology::make(201, triangles).value();
  }
  Topology fan_ = fan(), cloth_ = testing::Grid{4, 4}.topology();
  Surfaces surfaces_{{&fan_, &cloth_}};
  std::mt19937 random_{7};
};

// Labels of the last slice that the group of an element continues: those with a key in common, or else those
// with a neighboring one.
std::set<Index> continued(const Scene& scene, const std::vector<Element>& group,
                          const std::vector<Element>& before, const std::vector<Label>& labels,
                          std::size_t& by_neighbor) {
  std::set<Index> exact, near;
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (const Element& e : group) {
      if (are_joined(e, before[i], scene.same, scene.same)) exact.insert(labels[i].number);
      if (are_joined(e, before[i], scene.same, scene.neighbors) ||
          are_joined(e, before[i], scene.neighbors, scene.same))
        near.insert(labels[i].number);
    }
  }
  by_neighbor += exact.empty() && !near.empty() ? 1 : 0;
  return exact.empty() ? near : exact;
}

TEST(Joiner, JoinsAndContinuesWhatIsConnected) {
  Scene scene;
  Joiner joiner(scene.surfaces());
  std::vector<Element> before;
  std::vector<Label> labels;  // of those before
  std::size_t joined = 0, by_neighbor = 0;
  const std::size_t rounds = testing::rounds(4000);
  for (std::size_t round = 0; round < rounds; ++round) {
    const std::vector<Element> elements = scene.slice();
    joiner.begin(elements.size());
    for (const Element& e : elements) joiner.add(e.a, e.b);
    const Joiner::Groups& groups = joiner.find_groups();
    std::vector<std::size_t> root(elements.size());
    for (std::size_t i = 0; i < root.size(); ++i) {
      root[i] = i;
      for (std::size_t k = 0; k < i; ++k) {
        if (!are_joined(elements[i], elements[k], scene.same, scene.same)) continue;
        const std::size_t from = root[k], to = root[i];
        std::replace(root.begin(), root.end(), from, to);
      }
    }
    std::vector<Label> of_groups, own;
    for (std::size_t i = 0; i < root.size(); ++i) {
      std::vector<Element> group;
      for (std::size_t k = 0; k < root.size(); ++k) {
        ASSERT_EQ(groups.group[i] == groups.group[k], root[i] == root[k]) << round;
        if (root[k] == root[i]) group.push_back(elements[k]);
      }
      joined += group.size() > 1;
      std::set<Index> found;
      for (const Label& label : groups.labels[groups.group[i]]) found.insert(label.number);
      ASSERT_EQ(found, continued(scene, group, before, labels, by_neighbor)) << round;
      own.push_back({1 + groups.group[i], false});
    }
    for (Index g = 0; g < groups.labels.size(); ++g) of_groups.push_back({1 + g, false});
    joiner.end(of_groups);
    before = elements;
    labels = own;
  }
  EXPECT_GT(joined, rounds / 10);
  EXPECT_GT(by_neighbor, rounds / 10);
}

}  // namespace
}  // namespace foldproof
