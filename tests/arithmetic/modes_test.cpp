// Whatever floating-point mode a program has set, answers are the same bits in every thread, and the
// program's mode is restored afterwards.
#include <gtest/gtest.h>

#include <atomic>
#include <bit>
#include <cfenv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <thread>
#include <tuple>
#include <utility>

#include "base/callers.h"
#include "foldproof/check.h"
#include "foldproof/solver.h"
#include "mesh/grid.h"
#include "oracle/meshes.h"

namespace foldproof::testing {
namespace {

struct Mode {
  const char* name;
  int rounding;
  unsigned control;  // of SSE: flushing, traps
};
constexpr Mode kModes[] = {
    {"as at the start", FE_TONEAREST, 0x1f80},
    {"upward", FE_UPWARD, 0x1f80},
    {"downward", FE_DOWNWARD, 0x1f80},
    {"toward zero", FE_TOWARDZERO, 0x1f80},
#if defined(__SSE2__)
    {"denormal numbers flushed", FE_TONEAREST, 0x9fc0},
    {"results flushed", FE_TONEAREST, 0x9f80},
    {"operands flushed", FE_TONEAREST, 0x1fc0},
    {"division by zero and invalid trapped", FE_TONEAREST, 0x1d00},
#endif
};

// Sets a mode for this thread during its lifetime.
struct InMode {
  explicit InMode(const Mode& mode) : rounding(mode.rounding) {
    std::fegetenv(&before);
    std::fesetround(mode.rounding);
#if defined(__SSE2__)
    _mm_setcsr((_mm_getcsr() & 0x6000) | mode.control);
    set = _mm_getcsr() & ~0x3fu;
#endif
  }
  ~InMode() { std::fesetenv(&before); }
  bool is_unchanged() const {
#if defined(__SSE2__)
    if ((_mm_getcsr() & ~0x3fu) != set) return false;
#endif
    return std::fegetround() == rounding;
  }
  std::fenv_t before;
  int rounding;
  unsigned set = 0;
};

// Answers as bits.
struct Bits {
  std::vector<std::uint64_t> all;
  void add(double x) { all.push_back(std::bit_cast<std::uint64_t>(x)); }
  void add(std::uint64_t x) { all.push_back(x); }
};

// Two sheets that pass through each other, `size` across: the smallest ones have denormal coordinates.
struct Sheets {
  std::vector<Object> hierarchies;
  std::vector<std::vector<double>> x0, x1, apart;
  std::vector<double> folded;  // the first sheet, folded in half
  double across, thickness;
};
Sheets sheets(double size) {
  constexpr Index kSide = 9;
  const Topology topology =
      testing::Grid{kSide - 1, kSide - 1, false, testing::Diagonal::SecondToThird}.topology();
  Sheets s;
  for (int object = 0; object < 2; ++object) {
    std::vector<double> x0, x1;
    for (Index v = 0; v < kSide * kSide; ++v) {
      const Index row = v / kSide, column = v % kSide;
      const double x = (row + 0.3 * object) / kSide, y = (column + 0.2 * object) / kSide;
      const double z = 0.1 * std::sin(9 * x) * std::cos(7 * y) * (object == 0 ? 1 : -1) + 0.1 * object;
      for (const double c : {x, y, z}) x0.push_back(size * c);
      for (const double c : {x, y + 0.01, z + 0.03 * (object == 0 ? x : -y)}) x1.push_back(size * c);
    }
    s.hierarchies.push_back(std::make_shared<const Hierarchy>(Hierarchy::build(topology, x0, {8}).value()));
    s.x0.push_back(x0);
    s.x1.push_back(x1);
  }
  s.across = s.x0[0][3 * kSide * (kSide - 1)];
  s.thickness = 0.001 * s.across;
  s.apart = s.x1;
  for (std::size_t i = 0; i < s.apart[1].size(); i += 3) s.apart[1][i] += 5 * s.across;
  s.folded = s.x0[0];
  for (std::size_t i = 0; i < s.folded.size(); i += 3) s.folded[i] = std::abs(s.folded[i] - s.across / 2);
  return s;
}

Bits query_answers(const Sheets& s) {
  Bits bits;
  const std::vector<std::span<const double>> x0(s.x0.begin(), s.x0.end()), x1(s.x1.begin(), s.x1.end());
  StepChecker checker(s.hierarchies);
  StepResult step;
  for (const double thickness : {0.0, s.thickness}) {
    for (const bool back : {false, true}) {
      StepSettings settings;
      settings.thickness = thickness;
      EXPECT_TRUE(checker.check(back ? x1 : x0, back ? x0 : x1, settings, step).has_value());
      bits.add(step.tolerance);
      for (const auto& c : step.vertex_face) {
        bits.add(c.toi);
        bits.add(std::uint64_t{c.vertex} << 32 | c.face);
      }
      for (const auto& c : step.edge_edge) {
        bits.add(c.toi);
        bits.add(std::uint64_t{c.a[0]} << 32 | c.b[1]);
      }
    }
  }
  // A long step, which is searched in stretches.
  const std::vector<std::span<const double>> apart(s.apart.begin(), s.apart.end());
  EXPECT_TRUE(checker.check(apart, x0, {.earliest_only = true}, step).has_value());
  bits.add(step.earliest_toi);
  bits.add(step.work.refits);
  bits.add(step.work.node_tests);
  EXPECT_TRUE(checker.check(x0, x1, {.explain = true}, step).has_value());
  for (const auto& object : step.explanation.objects) {
    for (const float margin : object.margin) bits.add(double{margin});
  }
  StaticResult crossings;
  EXPECT_TRUE(checker.check_static(x1, {}, crossings).has_value());
  for (const auto& c : crossings.crossings) bits.add(std::uint64_t{c.triangle_a} << 32 | c.triangle_b);
  EXPECT_GT(bits.all.size(), 40u);
  return bits;
}

Bits solver_answers(const Sheets& s) {
  Bits bits;
  const auto faces = s.hierarchies[0].hierarchy()->topology().triangles();
  const auto mesh = CollisionMesh::make(s.x0[0], {}, {faces.begin(), faces.end()});
  ContactChecker checker(std::make_shared<const CollisionMesh>(*mesh));
  const std::vector<double>& folded = s.folded;
  const auto share = checker.collision_free_step_size(s.x0[0], folded);
  EXPECT_TRUE(share.has_value());
  bits.add(share->share);
  std::vector<double> there(folded.size());
  step_towards(s.x0[0], folded, 0.3, there);
  for (const double x : there) bits.add(x);
  bits.add(*checker.minimum_distance(there, s.across));
  return bits;
}

struct Pair {
  FourPoints x0, x1;
  Vec3 d, middle;  // almost in the plane of the first three, on the line of the first two: beyond the filters
};
std::vector<Pair> some_pairs(double size) {
  std::vector<Pair> pairs;
  for (int k = 0; k < 300; ++k) {
    const auto at = [&](int i) { return size * std::sin(i * 12.9898 + k * 0.7); };
    Pair p;
    for (int i = 0; i < 4; ++i) {
      p.x0[i] = {at(3 * i), at(3 * i + 1), at(3 * i + 2)};
      p.x1[i] = {at(3 * i + 40), at(3 * i + 41), at(3 * i + 42)};
    }
    p.d = p.x0[0] + (p.x0[1] - p.x0[0]) * 0.25 + (p.x0[2] - p.x0[0]) * 0.5;
    p.middle = p.x0[0] / 2 + p.x0[1] / 2;
    pairs.push_back(p);
  }
  return pairs;
}

Bits pair_answers(const std::vector<Pair>& pairs, double size) {
  Bits bits;
  for (const auto& [x0, x1, d, middle] : pairs) {
    for (const auto& answer : {vertex_face_ccd(x0, x1, {}), edge_edge_ccd(x0, x1, {})}) {
      bits.add(answer.toi);
      bits.add(std::uint64_t(answer.answer));
    }
    bits.add(vertex_face_closest(x0).distance);
    bits.add(edge_edge_closest(x0).distance);
    bits.add(ccd_resolution(size));
    bits.add(std::uint64_t{1} + orient3d(x0[0], x0[1], x0[2], d));
    bits.add(std::uint64_t(triangle_has_area(x0[0], middle, x0[1])));
    bits.add(std::uint64_t(triangles_intersect({x0[0], x0[1], x0[2]}, {x1[0], x1[1], d})));
    bits.add(std::uint64_t(segment_intersects_triangle({x1[0], d}, {x0[0], x0[1], x0[2]})));
    bits.add(std::uint64_t(triangles_fold(x0[0], x0[1], x0[2], d)));
  }
  return bits;
}

// With oneTBB: an arena that is made here has threads and tasks in the caller's mode.
template <class Body>
void in_own_arena(const Body& body) {
  with_threads(2, body);
}

template <class Answers>
void expect_same_in_all_modes(const Answers& answers) {
  const Bits expected = answers();
  for (const Mode& mode : kModes) {
    SCOPED_TRACE(mode.name);
    Bits inside;
    bool unchanged = false;
    std::thread([&] {  // with a mode and arena of its own
      const InMode in_mode(mode);
      in_own_arena([&] { inside = answers(); });
      unchanged = in_mode.is_unchanged();
    })
        .join();
    EXPECT_TRUE(unchanged);
    EXPECT_TRUE(inside.all == expected.all);
  }
}

constexpr double kSizes[] = {1, 0x1p-1030};

TEST(Modes, ChangeNoQuery) {
  for (const double size : kSizes) {
    const Sheets s = sheets(size);
    expect_same_in_all_modes([&] { return query_answers(s); });
  }
}

TEST(Modes, ChangeNoAnswerToASolver) {
  for (const double size : kSizes) {
    const Sheets s = sheets(size);
    expect_same_in_all_modes([&] { return solver_answers(s); });
  }
}

TEST(Modes, ChangeNoAnswerAboutAPair) {
  for (const double size : {1.0, 0x1p-1030, 0x1p-500, 0x1p1000}) {
    const std::vector<Pair> pairs = some_pairs(size);
    expect_same_in_all_modes([&] { return pair_answers(pairs, size); });
  }
}

bool is_plain() {
  const volatile double tiny = 0x1p-1060, one = 1, zero = 0, quarter = 0.25;
  const bool functions = std::nearbyint(quarter) == 0 && std::nearbyint(3 * quarter) == 1;
  return tiny * one != 0 && one + 0x1p-54 == one && -one - 0x1p-54 == -one && !std::isfinite(one / zero) &&
         functions;
}

// Tasks run in the mode that proofs assume, whether or not their arena was made in another one.
TEST(Modes, DoNotApplyToTasks) {
  for (const Mode& mode : kModes) {
    SCOPED_TRACE(mode.name);
    std::atomic<int> wrong{0}, tasks{0};
    const auto test = [&] {
      ++tasks;
      wrong += !is_plain();
    };
    std::thread([&] {
      const InMode in_mode(mode);
      in_own_arena([&] { parallel_for(std::size_t{0}, std::size_t{1000}, [&](std::size_t) { test(); }); });
      EXPECT_TRUE(in_mode.is_unchanged());
    }).join();
    EXPECT_EQ(tasks, 1000);
    EXPECT_EQ(wrong, 0);
  }
}

// A range of one block, which no other thread takes a part of.
TEST(Modes, DoNotApplyToASingleBlock) {
  for (const Mode& mode : kModes) {
    SCOPED_TRACE(mode.name);
    int plain = 0;
    std::thread([&] {
      const InMode in_mode(mode);
      in_own_arena([&] {
        plain = parallel_reduce(
            IndexRange{0, 1}, 1, 0, [](IndexRange, int) { return is_plain() ? 1 : 0; }, std::plus<>());
      });
      EXPECT_TRUE(in_mode.is_unchanged());
    }).join();
    EXPECT_EQ(plain, 1);
  }
}

TEST(Modes, DoNotApplyToCombinations) {
  if (!has_threads()) GTEST_SKIP() << "one thread combines nothing";
  for (const Mode& mode : kModes) {
    SCOPED_TRACE(mode.name);
    int plain = 0, all = 0;
    // oneTBB combines values only where another thread has taken a part, for which it has time while this
    // sleeps.
    const auto reduce = [&] {
      for (int attempt = 0; attempt < 100 && all == 0; ++attempt) {
        std::tie(all, plain) = parallel_reduce(
            IndexRange{0, 64}, 1, std::pair(0, 0),
            [](IndexRange, std::pair<int, int> value) {
              std::this_thread::sleep_for(std::chrono::microseconds(100));
              return value;
            },
            [](std::pair<int, int> a, std::pair<int, int> b) {
              return std::pair(a.first + b.first + 1, a.second + b.second + (is_plain() ? 1 : 0));
            });
      }
    };
    std::thread([&] {
      const InMode in_mode(mode);
      in_own_arena(reduce);
      EXPECT_TRUE(in_mode.is_unchanged());
    }).join();
    EXPECT_GT(all, 0);
    EXPECT_EQ(plain, all);
  }
}

}  // namespace
}  // namespace foldproof::testing
