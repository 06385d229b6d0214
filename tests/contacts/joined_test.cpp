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
// common; so are neighboring vertices that meet one face. What has nothing in common with the slice before is
// connected to what has one vertex in common with it and a neighbor of the other.
class JoinedByDefinition {
 public:
  explicit JoinedByDefinition(const Animation& animation) : animation_(animation) {}

  using Vertex = std::array<Index, 2>;  // with its object
  using Vertices = std::vector<Vertex>;

  void add(std::size_t slice, const Vertices& a, const Vertices& b) {
    const std::size_t element = group_.size();
    group_.push_back(element);
    slices_.resize(std::max(slices_.size(), slice + 1));
    const auto only_a = without(a, b), only_b = without(b, a);
    for (const auto& u : only_a) {
      for (const auto& w : only_b) {
        if (u != w) slices_[slice].push_back({std::minmax(u, w), element});
      }
    }
  }
  void add_vertex_face(std::size_t slice, const Vertex& vertex, const Vertex& face, const Vertices& corners) {
    for (const auto& [other, other_face, other_slice, element] : vertex_faces_) {
      if (other_slice == slice && other_face == face && are_neighbors(vertex, other))
        same_.push_back({element, group_.size()});
    }
    vertex_faces_.push_back({vertex, face, slice, group_.size()});
    add(slice, {vertex}, corners);
  }

  void join_all() {
    for (const auto& [a, b] : same_) join(a, b);
    for (const auto& keys : slices_) {
      std::map<std::pair<Vertex, Vertex>, std::size_t> first;
      for (const auto& [key, element] : keys) join(first.try_emplace(key, element).first->second, element);
    }
    // Before slices are joined, so that groups are those of one slice.
    std::vector<std::array<std::size_t, 2>> links;
    for (std::size_t k = 1; k < slices_.size(); ++k) {
      std::set<std::size_t> continued;
      const auto link_all = [&](const auto& are_linked, const std::set<std::size_t>& but) {
        std::vector<std::array<std::size_t, 2>> found;
        for (const auto& [key, element] : slices_[k]) {
          if (but.contains(group(element))) continue;
          for (const auto& [old, before] : slices_[k - 1]) {
            if (are_linked(key, old)) found.push_back({element, before});
          }
        }
        return found;
      };
      const auto same = link_all([](const auto& p, const auto& q) { return p == q; }, {});
      for (const auto& [element, before] : same) continued.insert(group(element));
      const auto near = link_all(
          [&](const auto& p, const auto& q) {
            return (p.first == q.first && are_neighbors(p.second, q.second)) ||
                   (p.first == q.second && are_neighbors(p.second, q.first)) ||
                   (p.second == q.first && are_neighbors(p.first, q.second)) ||
                   (p.second == q.second && are_neighbors(p.first, q.first));
          },
          continued);
      links.insert(links.end(), same.begin(), same.end());
      links.insert(links.end(), near.begin(), near.end());
    }
    for (const auto& [a, b] : links) join(a, b);
  }

  std::size_t group(std::size_t element) const {
    while (group_[element] != element) element = group_[element];
    return element;
  }

 private:
  static Vertices without(const Vertices& all, const Vertices& other) {
    Vertices out;
    for (const auto& v : all) {
      if (std::find(other.begin(), other.end(), v) == other.end()) out.push_back(v);
    }
    return out.empty() ? all : out;
  }
  bool are_neighbors(const Vertex& a, const Vertex& b) const {
    if (a[0] != b[0] || a == b) return false;
    const Edge edge{std::min(a[1], b[1]), std::max(a[1], b[1])};
    const auto edges = animation_.topologies[a[0]].edges();
    return std::binary_search(edges.begin(), edges.end(), edge);
  }
  void join(std::size_t a, std::size_t b) { group_[group(a)] = group(b); }

  struct VertexFace {
    Vertex vertex, face;
    std::size_t slice, element;
  };
  const Animation& animation_;
  std::vector<std::vector<std::pair<std::pair<Vertex, Vertex>, std::size_t>>> slices_;  // keys and elements
  std::vector<VertexFace> vertex_faces_;
  std::vector<std::array<std::size_t, 2>> same_;
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
      for (const VertexFaceCollision& c : step.vertex_face) {
        expected.add_vertex_face(slice, {c.vertex_object, c.vertex}, {c.face_object, c.face},
                                 face(c.face_object, c.face));
      }
      for (const EdgeEdgeCollision& c : step.edge_edge) {
        expected.add(slice, {{c.object_a, c.a[0]}, {c.object_a, c.a[1]}},
                     {{c.object_b, c.b[0]}, {c.object_b, c.b[1]}});
      }
      for (const auto* all : {&found.vertex_face[slice - 1], &found.edge_edge[slice - 1]})
        numbers.insert(numbers.end(), all->begin(), all->end());
    }
    for (const TriangleCrossing& c : found.crossings[slice])
      expected.add(slice, face(c.object_a, c.triangle_a), face(c.object_b, c.triangle_b));
    numbers.insert(numbers.end(), found.crossing_contacts[slice].begin(),
                   found.crossing_contacts[slice].end());
  }
  expected.join_all();
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
