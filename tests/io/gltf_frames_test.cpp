// Which keys of an animation are frames, and what is said about those that are not.
#include "io/gltf_builder.h"

namespace foldproof::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class GltfFramesTest : public IoTest {
 protected:
  std::unique_ptr<Motion> gltf(GltfBuilder& b, double fps = 24) {
    return open({files.write("a.gltf", b.gltf())}, {.fps = fps});
  }
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
    const auto motion = gltf(b, fps);
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
    return gltf(b, fps)->info().notes;
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

TEST_F(GltfFramesTest, NotesWhichClipsAreNotShown) {
  GltfBuilder b = still();
  const int brief = b.floats("SCALAR", {0, 1}), longer = b.floats("SCALAR", {0, 2});
  const int values = b.floats("VEC3", {0, 0, 0, 1, 0, 0});
  const auto clip = [&](const std::string& name, const std::string& path, int times) {
    b.animate(0, path, times, values);
    if (!name.empty()) b.json["animations"].back()["name"] = name;
  };
  const auto notes = [&] { return gltf(b)->info().notes; };
  clip("idle", "translation", longer);
  clip("grow", "scale", brief);
  EXPECT_THAT(notes(), IsEmpty()) << "clips that drive different properties play together";
  clip("attack", "translation", brief);
  EXPECT_THAT(notes(), ElementsAre("clip 'attack' is not shown: it drives what 'idle' drives, which is as "
                                   "long or longer; export it alone to check it"));
  clip("", "scale", brief);
  EXPECT_THAT(notes(), ElementsAre("clips 'attack' and animations[3] are not shown: they drive what 'idle' "
                                   "and 'grow' drive, which are as long or longer; export each alone to "
                                   "check it"));
  for (const char* name : {"a", "b", "c"}) clip(name, "translation", longer);
  EXPECT_THAT(notes(), ElementsAre(::testing::StartsWith("clips 'a', 'b', 'c' and 2 more are not shown: ")));
}

TEST_F(GltfFramesTest, NotesWhichClipsAreShownInPart) {
  GltfBuilder b = still();
  const int values = b.floats("VEC3", {0, 0, 0, 1, 0, 0});
  b.animate(0, "scale", b.floats("SCALAR", {0, 1}), values);
  Json& wave = b.json["animations"].back();
  wave["name"] = "wave";
  wave["channels"].push_back(wave["channels"][0]);
  wave["channels"].back()["target"]["path"] = "translation";
  b.animate(0, "translation", b.floats("SCALAR", {0, 2}), values);
  EXPECT_THAT(gltf(b)->info().notes,
              ::testing::ElementsAre("clip 'wave' is not shown in full: it drives some of what animations[1] "
                                     "drives, which is as long or longer; export it alone to check it"));
}

}  // namespace
}  // namespace foldproof::testing
