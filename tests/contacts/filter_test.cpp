// Contacts of a checker with a filter: no triangles cross that are ignored, also where a vertex on the border
// of two parts collides for the sake of one of them.
#include <gtest/gtest.h>

#include "contacts/scenes.h"
#include "foldproof/contacts.h"

namespace foldproof {
namespace {

using namespace oracle;

class FilteredContacts : public ::testing::TestWithParam<AnimationFamily> {};

TEST_P(FilteredContacts, CrossAsFilteredStaticQueriesSay) {
  Rng rng(31);
  const Animation animation = GetParam().make(rng);
  const auto objects = hierarchies(animation, 16);
  std::vector<std::vector<Index>> labels;
  std::vector<const Topology*> topologies;
  for (const Topology& topology : animation.topologies) {
    topologies.push_back(&topology);
    auto& of = labels.emplace_back();
    for (const Triangle& t : topology.triangles()) of.push_back(t[0] / 5 % 3);
  }
  const std::array<Index, 2> ignored[] = {{0, 1}, {2, 2}};
  const auto filter = ignore_labels(objects, labels, ignored).value();
  StepChecker checker(objects, filter), fresh(objects, filter), all(objects);
  auto finder = ContactFinder::make(topologies, {}, filter).value();
  StaticResult crossings, unfiltered;
  StepResult step;
  ASSERT_TRUE(checker.check_static(spans(animation.poses[0]), {}, crossings));
  finder.start(0, spans(animation.poses[0]), crossings);
  std::size_t kept = 0, left_out = 0;
  for (std::size_t k = 1; k < animation.poses.size(); ++k) {
    const auto x0 = spans(animation.poses[k - 1]), x1 = spans(animation.poses[k]);
    ASSERT_TRUE(checker.check(x0, x1, {}, step));
    finder.step(double(k) - 1, double(k), x0, x1, step);
    ASSERT_TRUE(fresh.check_static(x1, {.certificates = false}, crossings));
    ASSERT_TRUE(all.check_static(x1, {.certificates = false}, unfiltered));
    StaticResult got;
    got.crossings.assign(finder.crossings().begin(), finder.crossings().end());
    ASSERT_EQ(got.crossings.size(), crossings.crossings.size()) << "frame " << k;
    ASSERT_NO_FATAL_FAILURE(expect_same(got, crossings)) << "frame " << k;
    kept += crossings.crossings.size();
    left_out += unfiltered.crossings.size() - crossings.crossings.size();
  }
  EXPECT_GT(kept, 0u);
  EXPECT_GT(left_out, 0u);
}

INSTANTIATE_TEST_SUITE_P(Animations, FilteredContacts, ::testing::ValuesIn(generated_animations()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace foldproof
