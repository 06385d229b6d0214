#include <algorithm>

#include "adversary/run.h"

namespace foldproof::adversary {
namespace {

// How often a smaller case is tried.
constexpr int kMaxTries = 2000;

bool fails(const Case& c, int& tries) {
  if (c.objects.empty() || c.steps.empty() || ++tries > kMaxTries) return false;
  Tally unused;
  return !run_case(c, unused).empty();
}

// Takes parts away, halves first, as long as something goes wrong without them.
template <class Without>
void thin(Case& c, std::size_t count, int& tries, Without without) {
  for (std::size_t part = std::max<std::size_t>(1, count / 2); count > 0; part /= 2) {
    for (std::size_t first = 0; first < count;) {
      const std::size_t size = std::min(part, count - first);
      Case smaller = c;
      without(smaller, first, size);
      if (fails(smaller, tries)) {
        c = std::move(smaller);
        count -= size;
      } else {
        first += size;
      }
    }
    if (part == 1) return;
  }
}

template <class List>
void erase(List& list, std::size_t first, std::size_t count) {
  const auto at = list.begin() + static_cast<std::ptrdiff_t>(first);
  list.erase(at, at + static_cast<std::ptrdiff_t>(count));
}

void drop_unused_vertices(Case& c) {
  for (std::size_t k = 0; k < c.objects.size(); ++k) {
    Object& o = c.objects[k];
    std::vector<Index> place(o.vertex_count, kNoIndex);
    for (const Triangle& t : o.triangles) {
      for (const Index v : t) place[v] = 0;
    }
    Index count = 0;
    for (Index& v : place) v = v == kNoIndex ? v : count++;
    for (Triangle& t : o.triangles) t = {place[t[0]], place[t[1]], place[t[2]]};
    for (Step& step : c.steps) {
      for (Poses* poses : {&step.x0, &step.x1}) {
        Pose kept;
        for (Index v = 0; v < o.vertex_count; ++v) {
          if (place[v] != kNoIndex) kept.insert(kept.end(), &(*poses)[k][3 * v], &(*poses)[k][3 * v] + 3);
        }
        (*poses)[k] = std::move(kept);
      }
    }
    o.vertex_count = count;
  }
}

}  // namespace

Case cut_down(const Case& c) {
  Case small = c;
  int tries = 0;
  thin(small, small.steps.size(), tries,
       [](Case& t, std::size_t first, std::size_t count) { erase(t.steps, first, count); });
  thin(small, small.objects.size(), tries, [](Case& t, std::size_t first, std::size_t count) {
    erase(t.objects, first, count);
    for (Step& step : t.steps) {
      erase(step.x0, first, count);
      erase(step.x1, first, count);
    }
  });
  for (std::size_t k = 0; k < small.objects.size(); ++k) {
    thin(small, small.objects[k].triangles.size(), tries, [k](Case& t, std::size_t first, std::size_t count) {
      erase(t.objects[k].triangles, first, count);
      if (t.objects[k].triangles.empty()) t.objects.clear();
    });
  }
  for (Step& step : small.steps) {
    for (unsigned bit = 1; bit <= kSearches; bit *= 2) {
      const unsigned checks = step.checks;
      step.checks &= ~bit;
      if (step.checks != checks && !fails(small, tries)) step.checks = checks;
    }
  }
  Case bare = small;
  drop_unused_vertices(bare);
  return fails(bare, tries) ? bare : small;
}

}  // namespace foldproof::adversary
