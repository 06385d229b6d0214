// Repair: what is written is free, or said; starts; bad input.
#include <gmock/gmock.h>

#include <cstdlib>
#include <numbers>
#include <random>

#include "base/callers.h"
#include "base/rounds.h"
#include "repair/motions.h"

namespace foldproof::oracle {
namespace {

using testing::rounds;

TEST(Repair, AFreeMotionComesBackBitForBit) {
  TestMotion motion = pressed_balls(-0.05);
  const Repaired done = repaired(motion);
  expect_proven(motion, done);
  EXPECT_TRUE(done.report.unchanged);
  EXPECT_EQ(done.frames, motion.frames);
}

TEST(Repair, WhatNeedNotMoveDoesNot) {
  TestMotion motion = pressed_balls(0.1, 16);
  const Repaired done = repaired(motion, {.falloff = 0.1, .calm = false});
  expect_proven(motion, done);
  // Before they meet, and behind their middles, nothing moves.
  EXPECT_EQ(done.frames[0], motion.frames[0]);
  for (Index v = 0; v < motion.meshes[0].vertex_count; ++v) {
    if (Vec3::load(&motion.meshes[0].positions[3 * std::size_t{v}]).dot(kAxis) < 0) {
      ASSERT_EQ(done.correction(motion, 6, v), Vec3()) << v;
    }
  }
}

TEST(Repair, AllScalesAreRepairedAlike) {
  const TestMotion motion = pressed_balls(0.2, 6, 3);
  const Repaired done = repaired(motion);
  for (const double scale : {0x1p-30, 0x1p-10, 0x1p30}) {
    TestMotion scaled = motion;
    for (Pose& x : scaled.frames) {
      for (double& c : x) c *= scale;
    }
    const Repaired of_scaled = repaired(scaled);
    expect_proven(scaled, of_scaled);
    for (std::size_t i = 0; i < done.frames[3].size(); ++i)
      ASSERT_NEAR(of_scaled.frames[3][i] / scale, done.frames[3][i], 1e-6);
  }
}

TEST(Repair, TheSameOnAnyNumberOfThreads) {
  if (!has_threads()) GTEST_SKIP() << "the build has no threads";
  const TestMotion motion = pressed_balls(0.2, 14, 2);
  std::vector<Pose> one;
  for (const int threads : {1, 2, 5}) {
    with_threads(threads, [&] {
      const Repaired done = repaired(motion);
      if (one.empty()) one = done.frames;
      EXPECT_EQ(done.frames, one) << threads;
    });
  }
  EXPECT_NE(one, motion.frames);
}

TEST(Repair, SinglePrecisionIsProvenAfterRounding) {
  TestMotion motion = pressed_balls(0.2, 10, 4);
  const Repaired done = repaired(motion, {.single_precision = true});
  expect_proven(motion, done);
  for (const Pose& x : done.frames) {
    for (const double c : x) ASSERT_EQ(c, static_cast<double>(static_cast<float>(c)));
  }
  for (Pose& x : motion.frames) {
    for (double& c : x) c += 1e6;
  }
  EXPECT_THAT(error_of(motion.input(), {.single_precision = true}),
              ::testing::HasSubstr("single precision: is 0.12 mesh units coarse"));
}

// Also where a correction spreads over whole objects, so that they are shifted.
TEST(Repair, FramesFarFromContactsStayAsTheyWere) {
  const TestMotion motion = pressed_balls(0.2, 10, 12);
  for (const double falloff : {0.0, 10.0}) {
    const Repaired done = repaired(motion, {.falloff = falloff});
    expect_proven(motion, done);
    EXPECT_GT(done.report.frames[12].correction, 0.09);
    EXPECT_EQ(done.frames.front(), motion.frames.front());
    EXPECT_EQ(done.frames.back(), motion.frames.back());
  }
}

TEST(Repair, AStartIsRoundedToSinglePrecisionToo) {
  TestMotion motion = pressed_balls(0.4);
  Pose apart = motion.frames[0];
  for (double& c : apart) c += 1e-9;
  motion.frames = {motion.frames[6], motion.frames[5]};
  const Repaired done = repaired(motion, {.single_precision = true, .start = apart});
  expect_proven(motion, done);
  for (const Pose& x : done.frames) {
    for (const double c : x) ASSERT_EQ(c, static_cast<double>(static_cast<float>(c)));
  }
}

TEST(Repair, RefusesCoordinatesThatItCannotComputeWith) {
  TestMotion motion = pressed_balls(0.4);
  motion.frames[2][7] = 1e40;
  EXPECT_THAT(error_of(motion.input(), {}),
              ::testing::HasSubstr("object 0, frame 2, vertex 2: has the coordinate 1e+40"));
}

TEST(Repair, APoseWithoutAFreeFrameIsUntangled) {
  for (const double depth : {0.1, 0.3}) {
    TestMotion motion = pressed_balls(depth);
    motion.frames = {motion.frames[6]};
    const Repaired done = repaired(motion);
    expect_proven(motion, done);
    EXPECT_LT(done.largest(motion, 0, 0, 2 * motion.meshes[0].vertex_count), depth + done.report.clearance);
  }
}

// One frame, in which nothing touches or everything is tangled.
TEST(Repair, AThicknessThatNoFrameKeepsIsReached) {
  for (const double depth : {-0.01, 0.1}) {
    TestMotion motion = pressed_balls(depth);
    motion.frames = {motion.frames[6]};
    ASSERT_GT(touching(motion, motion.frames, 0.03), 0u);
    const Repaired done = repaired(motion, {.thickness = 0.03});
    expect_proven(motion, done, 0.03);
    EXPECT_EQ(done.report.before.size(), 1u);
    EXPECT_LT(done.largest(motion, 0, 0, 2 * motion.meshes[0].vertex_count),
              depth + 0.03 + done.report.clearance);
  }
}

// It begins and ends while the balls are pressed, and they part between.
TEST(Repair, ALoopCloses) {
  TestMotion motion = pressed_balls(0.2, 8, 4);
  std::vector<Pose> turned(motion.frames.begin() + 4, motion.frames.end());
  turned.insert(turned.end(), motion.frames.begin() + 1, motion.frames.begin() + 5);
  motion.frames = turned;
  ASSERT_EQ(motion.frames.front(), motion.frames.back());
  for (const bool calm : {false, true}) {
    const Repaired done = repaired(motion, {.calm = calm});
    expect_proven(motion, done);
    EXPECT_NE(done.frames.front(), motion.frames.front());
    EXPECT_EQ(done.frames.front(), done.frames.back());
    EXPECT_FALSE(done.report.open_loop);
  }
}

// Two sheets that cross each other along a line in all frames; a ball is pressed into one of them.
TEST(Repair, WhatCrossesFromTheStartStaysAndTheRestIsRepaired) {
  TestMotion motion;
  motion.meshes = {square(12), square(12), unit_sphere(5)};
  for (int k = 0; k < 5; ++k) {
    Pose x = motion.meshes[0].positions;
    for (Index v = 0; v < motion.meshes[1].vertex_count; ++v) {
      const Vec3 p = Vec3::load(&motion.meshes[1].positions[3 * std::size_t{v}]);
      x.insert(x.end(), {0.031 + 0.1 * p.x(), p.y(), p.x() - 0.47});
    }
    const Pose ball = placed(motion.meshes[2], 0.1, {0.7, 0.52, 0.15 - 0.02 * k});
    x.insert(x.end(), ball.begin(), ball.end());
    motion.frames.push_back(std::move(x));
  }
  const Repaired done = repaired(motion);
  EXPECT_TRUE(done.report.written);
  ASSERT_EQ(done.report.before.size(), 2u);
  ASSERT_EQ(done.report.remaining.size(), 1u);
  EXPECT_EQ(done.report.remaining[0].first_time, 0);
}

TEST(Repair, AGivenPoseIsWhereItStarts) {
  TestMotion motion = pressed_balls(0.4);
  const Pose apart = motion.frames[0];
  motion.frames = {motion.frames[6], motion.frames[5]};
  const Repaired done = repaired(motion, {.start = apart});
  expect_proven(motion, done);
  EXPECT_NEAR(done.largest(motion, 0, 0, motion.meshes[0].vertex_count), 0.2, 0.03);
  EXPECT_THAT(error_of(motion.input(), {.start = motion.frames[0]}),
              ::testing::HasSubstr("start: touches itself"));
  EXPECT_THAT(error_of(motion.input(), {.start = {0, 0, 0}}), ::testing::HasSubstr("start: has 1 vertices"));
  EXPECT_THAT(error_of(motion.input(), {.start = apart, .start_frame = 7}),
              ::testing::HasSubstr("but the motion has 2 frames"));
}

TEST(Repair, WhereNoFrameIsFreeItStartsInAKnownPoseThatIs) {
  TestMotion motion = pressed_balls(0.4);
  const Pose apart = motion.frames[0];
  int asked = 0;
  const auto known = [&asked, poses = std::vector<Pose>{motion.frames[6], apart}] {
    ++asked;
    return Result<std::vector<Pose>>(poses);
  };
  const Repaired without = repaired(motion, {.poses = known});  // its first frame is free
  EXPECT_EQ(without.frames, repaired(motion).frames);
  EXPECT_EQ(asked, 0);
  motion.frames = {motion.frames[6], motion.frames[5]};
  const Repaired done = repaired(motion, {.poses = known});
  expect_proven(motion, done);
  EXPECT_EQ(done.frames, repaired(motion, {.start = apart, .start_frame = 1}).frames);
  EXPECT_NE(done.frames, repaired(motion).frames);
  EXPECT_EQ(asked, 1);
  const auto small = [] { return Result<std::vector<Pose>>(std::vector<Pose>{{0, 0, 0}}); };
  EXPECT_THAT(error_of(motion.input(), {.poses = small}), ::testing::HasSubstr("poses: have another size"));
}

// A sheet that goes through itself along a line in every frame: nothing is free, and smoothing does not help.
TEST(Repair, WhereNothingHasAFreeStartNothingIsWritten) {
  TestMotion motion;
  motion.meshes = {square(4), square(4)};
  Pose x = motion.meshes[0].positions;
  for (Index v = 0; v < motion.meshes[1].vertex_count; ++v) {
    const Vec3 p = Vec3::load(&motion.meshes[1].positions[3 * std::size_t{v}]);
    x.insert(x.end(), {p.x() * 0.7, p.y() * 0.1 + 0.07, p.x() * 0.3 + p.y() + 0.03});
  }
  motion.frames = {x, x};
  motion.fix(0);
  motion.fix(1);
  motion.movable[1][12] = 1;  // its middle only, which cannot help
  const Repaired done = repaired(motion);
  EXPECT_FALSE(done.report.free);
  EXPECT_FALSE(done.report.written);
  EXPECT_TRUE(done.frames.empty());
  EXPECT_EQ(done.report.remaining.size(), done.report.before.size());
  EXPECT_GT(done.report.remaining.size(), 0u);
}

// Two fixed balls close on a third: the frames in which there is no room are those of the input, and named.
TEST(Repair, WhereThereIsNoWayFramesAreGivenUp) {
  TestMotion motion;
  const Mesh ball = unit_sphere(5);
  motion.meshes = {ball, ball, ball};
  for (int k = 0; k < 9; ++k) {
    const double gap = 0.5 * std::abs(k - 4) - 1.2;  // between the fixed ones, minus the third's size
    Pose x = placed(ball, 0.5, {0, 0, 0});
    for (const double side : {-1.0, 1.0}) {
      const Pose wall = placed(ball, 4, {side * (4.5 + gap / 2), 0, 0});
      x.insert(x.end(), wall.begin(), wall.end());
    }
    motion.frames.push_back(std::move(x));
  }
  motion.fix(1);
  motion.fix(2);
  const Repaired done = repaired(motion);
  EXPECT_TRUE(done.report.written);
  EXPECT_FALSE(done.report.free);
  EXPECT_FALSE(done.report.remaining.empty());
  ASSERT_EQ(done.report.frames.size(), 9u);
  EXPECT_EQ(done.report.frames[4].limit, RepairLimit::GivenUp);
  EXPECT_EQ(done.frames[4], motion.frames[4]);
  EXPECT_EQ(done.report.among_fixed.size(), 1u);  // the two walls
  EXPECT_EQ(done.report.frames[0].limit, RepairLimit::None);
}

// A long body that may not move turns and sinks through a sheet: straight ways lead through it at first.
TEST(Repair, WhereThereIsNoWayAtOnceItIsFollowedInParts) {
  constexpr Index kAround = 12, kRings = 8, kSide = 13;
  constexpr double kTurn = 0.9;
  Mesh body;
  body.vertex_count = kAround * (kRings + 1);
  for (Index v = 0; v < body.vertex_count; ++v) {
    const double t = std::numbers::pi * (v / kAround + 0.01) / (kRings + 0.02);
    const double turn = 2 * std::numbers::pi * (v % kAround) / kAround;
    const Vec3 p(std::sin(t) * std::cos(turn), std::sin(t) * std::sin(turn), 2 * std::cos(t));
    body.positions.insert(body.positions.end(), p.begin(), p.end());
    const Index next = v % kAround + 1 < kAround ? v + 1 : v + 1 - kAround;
    if (v >= kAround * kRings) continue;
    body.triangles.push_back({v, next, next + kAround});
    body.triangles.push_back({v, next + kAround, v + kAround});
  }
  TestMotion motion;
  Mesh sheet;
  sheet.vertex_count = kSide * kSide;
  for (Index v = 0; v < sheet.vertex_count; ++v) {
    const Index x = v % kSide, y = v / kSide;
    sheet.positions.insert(sheet.positions.end(), {x / (kSide - 1.0), y / (kSide - 1.0), 0});
    if (x + 1 == kSide || y + 1 == kSide) continue;
    sheet.triangles.push_back({v, v + 1, v + kSide + 1});
    sheet.triangles.push_back({v, v + kSide + 1, v + kSide});
  }
  motion.meshes = {body, sheet};
  for (int k = 0; k < 5; ++k) {
    const double c = std::cos(kTurn * k), s = std::sin(kTurn * k);
    Pose x;
    for (Index v = 0; v < body.vertex_count; ++v) {
      const Vec3 p = 0.2 * Vec3::load(&body.positions[3 * std::size_t{v}]);
      x.insert(x.end(), {0.47 + c * p.x() - s * p.z(), 0.52 + p.y(), 0.45 - 0.2 * k + s * p.x() + c * p.z()});
    }
    x.insert(x.end(), sheet.positions.begin(), sheet.positions.end());
    motion.frames.push_back(std::move(x));
  }
  motion.fix(0);
  RepairSettings settings;
  settings.calm = false;
  EXPECT_TRUE(repaired(motion, settings).report.free);
}

// Where some vertices of a triangle may move and others not, too.
TEST(Repair, ContactsAreThoseOfACheckWhateverMayMove) {
  TestMotion motion = pressed_balls(0.2, 8, 3, true);
  const std::size_t count = motion.meshes[0].vertex_count;
  for (const int movable_tenths : {0, 3, 7}) {
    std::mt19937_64 rng(5);
    motion.movable.assign(2, std::vector<std::uint8_t>(count, 0));
    motion.movable[0][farthest(motion, -kAxis)] = 1;
    for (auto& m : motion.movable[0]) m |= static_cast<int>(rng() % 10) < movable_tenths;
    const RepairReport report = repaired(motion).report;
    std::vector<Contact> found, expected;
    for (const auto* contacts : {&report.before, &report.among_fixed})
      found.insert(found.end(), contacts->begin(), contacts->end());
    std::size_t k = 0;
    std::vector<std::span<const double>> x;
    const auto next = [&]() -> Result<std::optional<MotionFrame>> {
      if (k == motion.frames.size()) return std::nullopt;
      x = motion.spans(motion.frames[k]);
      return MotionFrame{static_cast<double>(k++), x};
    };
    ASSERT_TRUE(find_contacts(motion.objects(), next, [&](Contact c) { expected.push_back(std::move(c)); }));
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].first_time, expected[i].first_time);
      EXPECT_EQ(found[i].last_time, expected[i].last_time);
      EXPECT_EQ(found[i].frames.size(), expected[i].frames.size());
      EXPECT_EQ(found[i].pairs, expected[i].pairs);
    }
    EXPECT_EQ(report.before.empty(), movable_tenths == 0);
  }
}

// Two balls change places: each comes to where the other was, and stays there.
TEST(Repair, WhatAMotionGoesThroughIsHeldBackAndNamed) {
  TestMotion motion = pressed_balls(0.1, 6, 3);
  const Mesh ball = motion.meshes[0];
  motion.frames.clear();
  for (int k = 0; k < 9; ++k) {
    Pose x = placed(ball, 1, kAxis * (1.6 - 0.4 * k));
    const Pose other = placed(ball, 1, kAxis * (0.4 * k - 1.6));
    x.insert(x.end(), other.begin(), other.end());
    motion.frames.push_back(std::move(x));
  }
  const RepairReport report = repaired(motion).report;
  EXPECT_TRUE(report.free);
  EXPECT_FALSE(report.frames.front().late);
  EXPECT_TRUE(report.frames.back().late);
}

// Two legs, hung side by side and `depth` too close to each other, swing past each other like scissors.
// `length`: half of a leg's. `late`: how many frames later than at the first one the swing begins.
TestMotion swinging_legs(double depth, double angle, int frames, double late, double length) {
  TestMotion motion;
  const Mesh ball = unit_sphere(16);
  motion.meshes = {ball, ball};
  for (int k = 0; k < frames; ++k) {
    const double swing = angle * (1 - 2 * (k + late) / (frames - 1));
    Pose& x = motion.frames.emplace_back();
    for (const int side : {-1, 1}) {
      const double c = std::cos(swing), s = side * std::sin(swing);
      for (Index v = 0; v < ball.vertex_count; ++v) {
        const Vec3 p = Vec3::load(&ball.positions[3 * std::size_t{v}]);
        const double along = p.x() / 2, down = length * (p.z() - 1);
        x.insert(x.end(), {c * along - s * down, p.y() / 2 + side * (1 - depth) / 2, s * along + c * down});
      }
    }
  }
  return motion;
}

// Feet move by twenty edges a frame; a repair that takes a leg around the wrong side of the other moves it by
// ten times the depth.
TEST(Repair, CoarseMotionsAreMovedByLittleMoreThanTheyAreDeep) {
  const auto expect_near = [](const TestMotion& motion, double depth) {
    const Repaired done = repaired(motion);
    expect_proven(motion, done);
    for (const RepairedFrame& frame : done.report.frames) EXPECT_LT(frame.correction, 2.5 * depth);
  };
  expect_near(swinging_legs(0.2, 0.8, 5, 0.7, 1.25), 0.2);
  expect_near(swinging_legs(0.15, 0.92, 5, 0.16, 1.86), 0.15);
}

TEST(Repair, IgnoredPairsMayTouch) {
  TestMotion motion = pressed_balls(0.2, 6, 2);
  const std::vector<std::vector<Index>> labels{{0}, {1}};
  const std::array<Index, 2> ignored[] = {{0, 1}};
  motion.filter = ignore_labels(motion.objects(), labels, ignored).value();
  const Repaired done = repaired(motion);
  EXPECT_TRUE(done.report.free);
  EXPECT_TRUE(done.report.unchanged);
  EXPECT_EQ(done.frames, motion.frames);
}

// A ball between two others, which press into it at the same time.
TEST(Repair, OnlyChosenContactsAreRepairedAndTheOthersAreLeft) {
  TestMotion motion = pressed_balls(0.2, 6, 3);
  motion.meshes.push_back(motion.meshes[0]);
  const Index first = motion.meshes[0].vertex_count + motion.meshes[1].vertex_count;
  for (int k = -3; k <= 3; ++k) {
    const Pose there = placed(motion.meshes[2], 1, kAxis * -(1.8 + 0.5 * std::abs(k) / 3));
    Pose& x = motion.frames[static_cast<std::size_t>(k + 3)];
    x.insert(x.end(), there.begin(), there.end());
  }
  ASSERT_EQ(repaired(motion).report.before.size(), 2u);
  RepairSettings settings;
  settings.falloff = 0.3;
  settings.chosen = [](const Contact& contact) { return contact.sides[1].object == 1; };
  const Repaired done = repaired(motion, settings);
  EXPECT_TRUE(done.report.free);
  ASSERT_EQ(done.report.before.size(), 1u);
  ASSERT_EQ(done.report.left.size(), 1u);
  EXPECT_EQ(done.report.left[0].sides[1].object, 2u);
  EXPECT_TRUE(done.report.remaining.empty());
  EXPECT_GT(done.largest(motion, 3, 0, first), 0.05);
  EXPECT_EQ(done.largest(motion, 3, first, first + motion.meshes[2].vertex_count), 0);
  EXPECT_GT(touching(motion, done.frames), 0u);
  // None is chosen: it stays as it was.
  settings.chosen = [](const Contact&) { return false; };
  const Repaired none = repaired(motion, settings);
  EXPECT_EQ(none.frames, motion.frames);
  EXPECT_EQ(none.report.left.size(), 2u);
  // All are: as without the choice.
  settings.chosen = [](const Contact&) { return true; };
  RepairSettings all;
  all.falloff = settings.falloff;
  EXPECT_EQ(repaired(motion, settings).frames, repaired(motion, all).frames);
}

// A ball that is thrown through a thin sheet between two frames: free in both, but not between them.
TEST(Repair, WhatPassesBetweenFramesIsHeldBack) {
  TestMotion motion;
  motion.meshes = {unit_sphere(6), square(12)};
  for (int k = 0; k < 6; ++k) {
    Pose x = placed(motion.meshes[0], 0.3, {0.02, 0.03, 1.05 - 0.7 * std::min(k, 3)});
    x.insert(x.end(), motion.meshes[1].positions.begin(), motion.meshes[1].positions.end());
    motion.frames.push_back(std::move(x));
  }
  motion.fix(1);
  const Repaired done = repaired(motion);
  expect_proven(motion, done);
  // It lies on the sheet, on the side from which it came.
  for (Index v = 0; v < motion.meshes[0].vertex_count; ++v)
    EXPECT_GT(done.frames[5][3 * std::size_t{v} + 2], 0) << v;
}

TEST(Repair, CopiesMoveWithTheirVertices) {
  TestMotion motion = pressed_balls(0.3, 6, 3);
  // The last vertex of the first ball's file is a copy of its first, in no triangle.
  const Index n = motion.meshes[0].vertex_count;
  Mesh& ball = motion.meshes[0];
  const Index nearest = farthest(motion, kAxis);
  ++ball.vertex_count;
  for (Pose& x : motion.frames) {
    const std::array<double, 3> p{x[3 * nearest], x[3 * nearest + 1], x[3 * nearest + 2]};
    x.insert(x.begin() + 3 * n, p.begin(), p.end());
  }
  RepairInput input = motion.input();
  input.objects[0].merged.resize(n + 1);
  for (Index v = 0; v <= n; ++v) input.objects[0].merged[v] = v == n ? nearest : v;
  std::size_t moved = 0;
  const auto report = repair(input, {}, [&](double time, std::span<const double> x) -> Result<void> {
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(x[3 * n + axis], x[3 * nearest + axis]);
    moved += x[3 * n] != motion.frames[static_cast<std::size_t>(time)][3 * n];
    return {};
  });
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->free);
  EXPECT_GT(moved, 0u);
}

TEST(Repair, BadInputIsRefusedInOneLine) {
  const TestMotion motion = pressed_balls(0.2, 6, 1);
  const auto has = [](const char* text) { return ::testing::HasSubstr(text); };
  RepairInput input = motion.input();
  EXPECT_THAT(error_of(input, {.thickness = -1}), has("thickness: is not a length"));
  EXPECT_THAT(error_of(input, {.thickness = NAN}), has("thickness: is not a length"));
  EXPECT_THAT(error_of(input, {.falloff = INFINITY}), has("falloff: is not a length"));
  EXPECT_THAT(error_of(input, {.thickness = 0.5}),
              has("thickness: 0.5 is more than the gaps of object 1 itself: in frame 0"));
  input.objects[0].movable = {1, 0};
  EXPECT_THAT(error_of(input), has("object 0: what may move is for 2 vertices"));
  for (RepairObject& object : input.objects) object.movable.assign(motion.meshes[0].vertex_count, 0);
  EXPECT_THAT(error_of(input), has("repair: nothing may move"));
  input = motion.input();
  input.objects[1].merged.assign(motion.meshes[1].vertex_count, 10'000);
  EXPECT_THAT(error_of(input), has("object 1: merged names a vertex beyond its last"));
  TestMotion nan = motion;
  nan.frames[1][7] = NAN;
  EXPECT_THAT(error_of(nan.input()), has("object 0, frame 1, vertex "));
  EXPECT_THAT(error_of({}), has("there is nothing to repair"));
}

TEST(Repair, InterruptedAtAnyTimeItWritesNothing) {
  const TestMotion motion = pressed_balls(0.2, 5, 2);
  int calls = 0;
  RepairSettings settings;
  settings.interrupted = [&] { return ++calls, false; };
  repaired(motion, settings);
  const int all = calls;
  ASSERT_GT(all, 10);
  for (int stop = 1; stop < all - 5; stop += 1 + all / 12) {  // the last calls come while frames are written
    calls = 0;
    settings.interrupted = [&] { return ++calls >= stop; };
    int written = 0;
    const auto report =
        repair(motion.input(), settings, [&](double, std::span<const double>) -> Result<void> {
          ++written;
          return {};
        });
    ASSERT_FALSE(report) << stop;
    EXPECT_EQ(report.error().code, ErrorCode::Interrupted);
    EXPECT_EQ(written, 0);
  }
}

TEST(Repair, InterruptedItKeepsWhatIsFinished) {
  const TestMotion motion = pressed_balls(0.2, 5, 4);
  int calls = 0;
  RepairSettings settings{.keep = true};
  settings.interrupted = [&] { return ++calls > 25; };
  const Repaired done = repaired(motion, settings);
  EXPECT_TRUE(done.report.interrupted);
  ASSERT_GT(done.frames.size(), 1u);
  EXPECT_LE(done.frames.size(), motion.frames.size());
  for (std::size_t k = 0; k < done.times.size(); ++k) EXPECT_EQ(done.times[k], static_cast<double>(k));
  EXPECT_EQ(touching(motion, done.frames), 0u);
}

TEST(Repair, AddedFramesAreProvenToo) {
  TestMotion motion;
  motion.meshes = {unit_sphere(6), square(12)};
  for (int k = 0; k < 4; ++k) {
    Pose x = placed(motion.meshes[0], 0.3, {0.02, 0.03, 1.05 - 0.9 * k});
    x.insert(x.end(), motion.meshes[1].positions.begin(), motion.meshes[1].positions.end());
    motion.frames.push_back(std::move(x));
  }
  motion.fix(1);
  const Repaired done = repaired(motion, {.in_betweens = 3});
  EXPECT_TRUE(done.report.free);
  EXPECT_EQ(touching(motion, done.frames), 0u);
  EXPECT_TRUE(std::is_sorted(done.times.begin(), done.times.end()));
  for (const double whole : {0.0, 1.0, 2.0, 3.0})
    EXPECT_EQ(std::count(done.times.begin(), done.times.end(), whole), 1) << whole;
  EXPECT_LE(done.times.size(), 13u);
}

TEST(Repair, AnErrorOfTheWriterIsReturned) {
  const TestMotion motion = pressed_balls(0.1, 5, 1);
  const auto report = repair(motion.input(), {}, [](double, std::span<const double>) -> Result<void> {
    return fail(ErrorCode::FileAccess, "out.npz", "the disk is full", "make room");
  });
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().line(), "out.npz: the disk is full; make room");
}

// Many small motions: bodies of all families fly through each other, some of them fixed. What is written is
// free, or what is said to remain is what a checker finds.
bool all_motions() { return std::getenv("FOLDPROOF_ALL_MOTIONS") != nullptr; }

class RandomMotions : public ::testing::TestWithParam<int> {};

TEST_P(RandomMotions, AreFreeOrSaid) {
  std::mt19937_64 rng(static_cast<std::uint64_t>(GetParam()));
  const auto families = mesh_families();
  TestMotion motion;
  for (int i = 0; i < 2; ++i) {
    Mesh mesh = families[rng() % families.size()].make(rng);
    motion.meshes.push_back(std::move(mesh));
  }
  const double scale = std::pow(10.0, uniform(rng, -9, 9));
  Vec3 from(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
  from = from.normalized() * 2.5;
  const Vec3 to = from * uniform(rng, -1, 0.5);
  for (int k = 0; k < 5; ++k) {
    Pose x;
    for (std::size_t i = 0; i < 2; ++i) {
      const Pose placed_there = placed(motion.meshes[i], 1, i == 0 ? Vec3() : from + (to - from) * (k / 4.0));
      x.insert(x.end(), placed_there.begin(), placed_there.end());
    }
    for (double& c : x) c *= scale;
    motion.frames.push_back(std::move(x));
  }
  if (rng() % 3 == 0) motion.fix(rng() % 2);
  const Repaired done = repaired(motion);
  if (!done.report.written) {
    EXPECT_FALSE(done.report.free);
    EXPECT_FALSE(done.report.remaining.empty());
    return;
  }
  ASSERT_EQ(done.frames.size(), motion.frames.size());
  EXPECT_EQ(done.report.free && done.report.among_fixed.empty(), touching(motion, done.frames) == 0);
  EXPECT_EQ(done.report.free, done.report.remaining.empty());
  for (const RepairedFrame& frame : done.report.frames) {
    EXPECT_TRUE(!done.report.free || frame.limit == RepairLimit::None);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomMotions, ::testing::Range(0, rounds(all_motions() ? 1000 : 16)));

}  // namespace
}  // namespace foldproof::oracle
