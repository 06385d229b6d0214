// Pairs and crossings are joined into contacts: each exactly once, the same way however it is computed.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "base/callers.h"
#include "contacts/scenes.h"

namespace foldproof {
namespace {

using namespace oracle;

// What is the same for every numbering of the contacts: which pairs have one contact, and what it is.
void expect_same_contacts(const Found& a, const Found& b) {
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  for (std::size_t i = 0; i < a.contacts.size(); ++i) {
    const Contact &p = a.contacts[i], &q = b.contacts[i];
    EXPECT_EQ(p.number, q.number);
    EXPECT_EQ(p.joined, q.joined);
    EXPECT_EQ(p.first_time, q.first_time);
    EXPECT_EQ(p.last_time, q.last_time);
    EXPECT_EQ(p.pairs, q.pairs);
    EXPECT_EQ(p.frames.size(), q.frames.size());
    EXPECT_EQ(p.worst, q.worst);
    EXPECT_EQ(p.depth(), q.depth());
    EXPECT_EQ(p.point, q.point);
    for (int side = 0; side < 2; ++side) EXPECT_EQ(p.sides[side].triangles, q.sides[side].triangles);
  }
  EXPECT_EQ(a.vertex_face, b.vertex_face);
  EXPECT_EQ(a.edge_edge, b.edge_edge);
  EXPECT_EQ(a.crossing_contacts, b.crossing_contacts);
}

std::map<Index, std::uint64_t> pairs_per_contact(const Found& found) {
  std::map<Index, std::uint64_t> count;
  for (std::size_t k = 0; k < found.steps.size(); ++k) {
    EXPECT_EQ(found.vertex_face[k].size(), found.steps[k].vertex_face.size());
    EXPECT_EQ(found.edge_edge[k].size(), found.steps[k].edge_edge.size());
    for (const Index number : found.vertex_face[k]) ++count[number];
    for (const Index number : found.edge_edge[k]) ++count[number];
  }
  return count;
}

class Joined : public ::testing::TestWithParam<AnimationFamily> {
 protected:
  Animation animation() const {
    Rng rng(11);
    return GetParam().make(rng);
  }
};

TEST_P(Joined, EveryPairHasOneContactAndEveryContactItsPairs) {
  const Animation animation = this->animation();
  const Found found = contacts_of(animation);
  const auto pairs = pairs_per_contact(found);
  std::map<Index, std::uint64_t> crossings;
  for (std::size_t k = 0; k < animation.poses.size(); ++k) {
    ASSERT_EQ(found.crossing_contacts[k].size(), found.crossings[k].size());
    for (const Index number : found.crossing_contacts[k]) ++crossings[number];
  }
  std::set<Index> numbers;
  for (const Contact& contact : found.contacts) {
    EXPECT_TRUE(numbers.insert(contact.number).second);
    const auto at = pairs.find(contact.number);
    EXPECT_EQ(contact.pairs, at == pairs.end() ? 0 : at->second);
    std::uint64_t crossing = 0;
    for (const ContactFrame& frame : contact.frames) crossing += frame.crossings;
    EXPECT_EQ(crossing, crossings[contact.number]);
    EXPECT_GT(contact.pairs + crossing, 0u);
    EXPECT_LE(contact.first_time, contact.last_time);
    for (const ContactFrame& frame : contact.frames) {
      EXPECT_GE(frame.time, std::floor(contact.first_time));
      EXPECT_LE(frame.time, contact.last_time);
    }
  }
  for (const auto& [number, count] : pairs) EXPECT_TRUE(numbers.contains(number));
}

// All pairs and crossings of an animation, joined by the definition: those of one slice of time, or of two
// that follow each other, are connected when they have a vertex of the one side and one of the other in
// common.
class JoinedByDefinition {
 public:
  explicit JoinedByDefinition(const Animation& animation) : animation_(animation) {}

  void add(std::size_t slice, const std::vector<std::array<Index, 2>>& a,
           const std::vector<std::array<Index, 2>>& b) {
    const std::size_t element = group_.size();
    group_.push_back(element);
    const auto only_a = without(a, b), only_b = without(b, a);
    for (const auto& u : only_a) {
      for (const auto& w : only_b) {
        if (u == w) continue;
        const auto key = std::minmax(u, w);
        first_[slice].try_emplace(key, element);
        join(first_[slice][key], element);
        if (slice == 0) continue;
        const auto before = first_[slice - 1].find(key);
        if (before != first_[slice - 1].end()) join(before->second, element);
      }
    }
  }

  std::size_t group(std::size_t element) const {
    while (group_[element] != element) element = group_[element];
    return element;
  }

  // The vertices of the triangles that have all of `of`, with their object.
  std::vector<std::array<Index, 2>> around(Index object, const std::vector<Index>& of) const {
    std::set<std::array<Index, 2>> out;
    for (const Index v : of) out.insert({object, v});
    for (const Triangle& t : animation_.topologies[object].triangles()) {
      const auto has = [&](Index v) { return std::find(t.begin(), t.end(), v) != t.end(); };
      if (!std::all_of(of.begin(), of.end(), has)) continue;
      for (const Index v : t) out.insert({object, v});
    }
    return {out.begin(), out.end()};
  }

 private:
  using Vertices = std::vector<std::array<Index, 2>>;
  static Vertices without(const Vertices& all, const Vertices& other) {
    Vertices out;
    for (const auto& v : all) {
      if (std::find(other.begin(), other.end(), v) == other.end()) out.push_back(v);
    }
    return out.empty() ? all : out;
  }
  void join(std::size_t a, std::size_t b) { group_[group(a)] = group(b); }

  const Animation& animation_;
  std::map<std::size_t, std::map<std::pair<std::array<Index, 2>, std::array<Index, 2>>, std::size_t>> first_;
  std::vector<std::size_t> group_;
};

TEST_P(Joined, ContactsAreWhatTheDefinitionSays) {
  const Animation animation = this->animation();
  const Found found = contacts_of(animation);
  JoinedByDefinition expected(animation);
  std::vector<Index> numbers;
  const auto face = [&](Index object, Index t) {
    const Triangle& corners = animation.topologies[object].triangles()[t];
    std::set<std::array<Index, 2>> out;
    for (const Index v : corners) out.insert({object, v});
    return std::vector<std::array<Index, 2>>(out.begin(), out.end());
  };
  for (std::size_t slice = 0; slice < animation.poses.size(); ++slice) {
    if (slice > 0) {
      const StepResult& step = found.steps[slice - 1];
      for (const VertexFaceCollision& c : step.vertex_face)
        expected.add(slice, expected.around(c.vertex_object, {c.vertex}), face(c.face_object, c.face));
      for (const EdgeEdgeCollision& c : step.edge_edge) {
        expected.add(slice, expected.around(c.object_a, {c.a[0], c.a[1]}),
                     expected.around(c.object_b, {c.b[0], c.b[1]}));
      }
      for (const auto* all : {&found.vertex_face[slice - 1], &found.edge_edge[slice - 1]})
        numbers.insert(numbers.end(), all->begin(), all->end());
    }
    for (const TriangleCrossing& c : found.crossings[slice])
      expected.add(slice, face(c.object_a, c.triangle_a), face(c.object_b, c.triangle_b));
    numbers.insert(numbers.end(), found.crossing_contacts[slice].begin(),
                   found.crossing_contacts[slice].end());
  }
  std::map<std::size_t, Index> number_of;
  std::set<Index> used;
  for (std::size_t e = 0; e < numbers.size(); ++e) {
    const auto [at, is_new] = number_of.try_emplace(expected.group(e), numbers[e]);
    EXPECT_EQ(at->second, numbers[e]) << "element " << e;
    if (is_new) {
      EXPECT_TRUE(used.insert(numbers[e]).second) << "contact " << numbers[e] << " has two groups";
    }
  }
  EXPECT_EQ(used.size(), found.contacts.size());
}

TEST_P(Joined, TheSameForAnyNumberOfThreads) {
  if (!has_threads()) GTEST_SKIP() << "there is one thread";
  const Animation animation = this->animation();
  Found one, several;
  with_threads(1, [&] { one = contacts_of(animation); });
  with_threads(4, [&] { several = contacts_of(animation); });
  EXPECT_GT(one.contacts.size(), 0u);
  expect_same_contacts(one, several);
}

INSTANTIATE_TEST_SUITE_P(Families, Joined,
                         ::testing::ValuesIn(generated_animations().begin(), generated_animations().end()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace foldproof
