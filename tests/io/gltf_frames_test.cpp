// Which keys of an animation are frames, and what is said about those that are not.
#include "io/gltf_builder.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class GltfFramesTest : public GltfIoTest {
 protected:
  /// A triangle without animations.
  static GltfBuilder still() {
    GltfBuilder b;
    b.triangle();
    b.json["nodes"] = {{{"mesh", 0}}};
    return b;
  }
};

TEST_F(GltfFramesTest, KeysAreFramesAlthoughTheirTimesAreRounded) {
  // Exporters round the quotient, or multiply by a rounded 1/24. Many of these times come after k / 24.
  for (const bool twice : {false, true}) {
    SCOPED_TRACE(twice);
    GltfBuilder b = still();
    std::vector<float> times, values;
    for (int k = 0; k < 500; ++k) {
      times.push_back(twice ? static_cast<float>(k) * (1.0f / 24) : static_cast<float>(k / 24.0));
      values.insert(values.end(), {static_cast<float>(k % 7), 0, 0});
    }
    b.animate(0, "translation", b.floats("SCALAR", times), b.floats("VEC3", values))["interpolation"] =
        "STEP";
    const auto motion = gltf(b);
    ASSERT_TRUE(motion);
    ASSERT_EQ(motion->frame_count(), 500u);
    for (Index k = 0; k < 500; ++k) ASSERT_EQ(frame(*motion, k)[0], k % 7) << k;
    EXPECT_THAT(motion->info().notes, IsEmpty());
  }
}

TEST_F(GltfFramesTest, AKeyOfASplineIsAFrameOfItsValue) {
  GltfBuilder b = still();
  // 2/24 rounds up. Only the key's own value is not huge there.
  const auto at = static_cast<float>(2 / 24.0);
  ASSERT_GT(static_cast<double>(at), 2 / 24.0);
  const float big = 1e30f;
  b.animate(0, "translation", b.floats("SCALAR", {0, at, 1}),
            b.floats("VEC3", {0,   0, 0, big, 0, 0, big, 0, 0,  //
                              big, 0, 0, 5,   0, 0, big, 0, 0,  //
                              big, 0, 0, big, 0, 0, 0,   0, 0}))["interpolation"] = "CUBICSPLINE";
  const auto motion = gltf(b);
  ASSERT_TRUE(motion);
  EXPECT_EQ(frame(*motion, 2)[0], 5);
}

TEST_F(GltfFramesTest, TheLastFrameIsTheLastKey) {
  const auto x = [&](const std::vector<float>& times, double fps) {
    GltfBuilder b = still();
    std::vector<float> values;
    for (std::size_t i = 0; i < times.size(); ++i) values.insert(values.end(), {static_cast<float>(i), 0, 0});
    b.animate(0, "translation", b.floats("SCALAR", times), b.floats("VEC3", values))["interpolation"] =
        "STEP";
    const auto motion = gltf(b, {.fps = fps});
    std::vector<double> shown;
    for (Index k = 0; k < motion->frame_count(); ++k) shown.push_back(frame(*motion, k)[0]);
    return shown;
  };
  EXPECT_THAT(x({0}, 24), ElementsAre(0));
  EXPECT_THAT(x({0, 1e-6f}, 24), ElementsAre(0, 1)) << "however short the motion is";
  EXPECT_THAT(x({0, 1e-45f}, 1e-300), ElementsAre(0, 1));
  EXPECT_THAT(x({0, 1, 2.00002f}, 1), ElementsAre(0, 1, 2)) << "times that were added up";
  EXPECT_THAT(x({0, 1, 1.99998f}, 1), ElementsAre(0, 1, 2));
  EXPECT_THAT(x({0, 1, 2.01f}, 1), ElementsAre(0, 1, 1, 2));
}

TEST_F(GltfFramesTest, NotesHowManyKeysLieBetweenFrames) {
  const auto notes = [&](std::vector<float> times, double fps) {
    GltfBuilder b = still();
    std::ranges::sort(times);
    const int input = b.floats("SCALAR", times), again = b.floats("SCALAR", times);
    const int output = b.floats("VEC3", std::vector<float>(3 * times.size(), 1));
    b.animate(0, "translation", input, output);
    b.animate(0, "scale", again, output);
    return gltf(b, {.fps = fps})->info().notes;
  };
  const auto every = [](double seconds, int count) {
    std::vector<float> times;
    for (int k = 0; k < count; ++k) times.push_back(static_cast<float>(k * seconds));
    return times;
  };
  EXPECT_THAT(notes(every(1 / 24.0, 1000), 24), IsEmpty());
  EXPECT_THAT(notes(every(1 / 12.0, 1000), 24), IsEmpty());
  EXPECT_THAT(notes(every(1 / 30.0, 31), 24),
              ElementsAre("24 keys lie between frames at 24 a second; with --fps 30 every key is a frame"));
  EXPECT_THAT(notes(every(1 / 30.0, 31), 30), IsEmpty());
  EXPECT_THAT(notes({0, 1 / 60.0f, 1}, 24),
              ElementsAre("1 key lies between frames at 24 a second; with --fps 60 every key is a frame"));
  EXPECT_THAT(notes(every(1 / 25.0, 5000), 60),
              ElementsAre(HasSubstr("; with --fps 75 every key is a frame")));
  EXPECT_THAT(notes(every(1.001 / 30, 300), 29.97),
              ElementsAre(HasSubstr("; with --fps 29.97003 every key is a frame")));
  EXPECT_THAT(notes(every(1.001 / 30, 300), 29.97003), IsEmpty());
  EXPECT_THAT(notes({0, 0.1234567f, 0.7654321f, 1}, 24),
              ElementsAre("2 keys lie between frames at 24 a second; a higher --fps comes closer to them"));
  // More frames than a motion may have are no help.
  EXPECT_THAT(notes({0, 1 / 30.0f, 40000}, 24), ElementsAre(HasSubstr("; a higher --fps ")));
  // The frame of the last key, which comes just after another, does not show the other.
  EXPECT_THAT(notes({0, 1, 2, 2.00002f}, 1), ElementsAre(HasSubstr("1 key lies between frames")));
}

/// Clips of one node: 'idle' and 'attack' drive its place, one without a name its size.
GltfBuilder clips() {
  GltfBuilder b;
  b.triangle();
  b.json["nodes"] = {{{"mesh", 0}}};
  const auto clip = [&](const char* path, float seconds, float x) {
    b.animate(0, path, b.floats("SCALAR", {0, seconds}), b.floats("VEC3", {x, x, x, x, x, x}));
    return &b.json["animations"].back();
  };
  (*clip("translation", 1, 3))["name"] = "idle";
  (*clip("translation", 2, 5))["name"] = "attack";
  clip("scale", 2, 7);
  return b;
}

TEST_F(GltfFramesTest, TheLongestClipIsShown) {
  GltfBuilder b = clips();
  const auto motion = gltf(b, {.fps = 1});
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->frame_count(), 3u);
  EXPECT_THAT(frame(*motion, 0), ElementsAre(5, 5, 5, 6, 5, 5, 5, 6, 5)) << "no other clip plays with it";
  const MotionInfo& info = motion->info();
  EXPECT_THAT(info.clips, ElementsAre("idle", "attack", "animations[2]"));
  EXPECT_EQ(info.taken_as, "clip 'attack', the longest of 3");
  EXPECT_THAT(info.unchecked, ElementsAre("2 other clips were not checked (--clip)"));
  EXPECT_THAT(info.notes, IsEmpty());
  b.json["animations"].erase(1);
  EXPECT_THAT(gltf(b, {.fps = 1})->info().unchecked, ElementsAre("the other clip was not checked (--clip)"));
  b.json["animations"].erase(0);
  EXPECT_EQ(gltf(b, {.fps = 1})->info().taken_as, "") << "there is no other";
}

TEST_F(GltfFramesTest, AClipIsChosenByName) {
  GltfBuilder b = clips();
  const std::string file = files.write("a.gltf", b.gltf());
  const auto x = [&](const std::string& clip) {
    const auto motion = open({file}, {.fps = 1, .clip = clip});
    EXPECT_EQ(motion->info().taken_as, "clip '" + clip + "'");
    EXPECT_THAT(motion->info().unchecked, IsEmpty()) << "what was asked for is checked";
    return frame(*motion, 0)[3];
  };
  EXPECT_EQ(x("idle"), 4);
  EXPECT_EQ(x("attack"), 6);
  EXPECT_EQ(x("animations[2]"), 7);
  EXPECT_EQ(
      open_error({file}, {.clip = "attak"}),
      "a.gltf: has no clip 'attak'; did you mean 'attack'? it has 'idle', 'attack' and 'animations[2]'");
  EXPECT_EQ(open_error({file}, {.clip = "run"}),
            "a.gltf: has no clip 'run'; it has 'idle', 'attack' and 'animations[2]'");
  // Names that do not tell clips apart are none.
  b.json["animations"][0]["name"] = "attack";
  const auto twice = open({files.write("b.gltf", b.gltf())});
  EXPECT_THAT(twice->info().clips, ElementsAre("animations[0]", "animations[1]", "animations[2]"));

  GltfBuilder none = still();
  const std::string plain = files.write("c.gltf", none.gltf());
  EXPECT_EQ(open_error({plain}, {.clip = "idle"}),
            "--clip: is given, but no file has animations; leave it out; only .gltf and .glb have them");
  EXPECT_EQ(open_motions(std::vector{file, plain}, {.clip = "idle"})->size(), 2u) << "one has it";
}

}  // namespace
}  // namespace foldproof::testing
