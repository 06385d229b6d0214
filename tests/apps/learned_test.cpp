// train, info and predict on the command line to learn shapes.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "learned/scene.h"

namespace foldproof {
namespace {

using namespace foldproof::testing;
using nlohmann::json;
using ::testing::HasSubstr;

/// Poses of a tube, a run of it that goes elsewhere, and another mesh.
struct Scene : Workplace {
  Scene() {
    const auto poses =
        bending_twice(kSmallTubeToLearn, {{0, 0}, {0.5, 0}, {1, 0}, {-0.5, 0}, {-1, 0}, {2, 0}});
    const auto run = bending_twice(kSmallTubeToLearn, {{0.2, 0}, {0.1, 1}, {0.7, 0.2}});
    EXPECT_TRUE(write_npz(path() + "/poses.npz", *poses));
    EXPECT_TRUE(write_npz(path() + "/run.npz", *run));
    EXPECT_TRUE(write_npz(path() + "/other.npz", *bending_tube(kSmallTube, {0, 1, 2})));
    EXPECT_EQ(this->run({"train", "poses.npz", "-o", "tube.model", "--energy", "1", "--quiet"}).code, 0);
  }
  /// The model's key points in a motion of this scene, as a table.
  void write_table(const std::string& name, Motion& motion) const {
    std::istringstream list(run({"predict", "tube.model", "--list-key-points"}).out);
    std::string text = "frame,vertex,x,y,z\n";
    for (Index v; list >> v;) {
      for (Index k = 0; k < motion.frame_count(); ++k) {
        const Eigen::VectorXd x = frame_of(motion, k);
        text += fmt::format("{},{},{:f},{:f},{:f}\n", k, v, x[3 * v], x[3 * v + 1], x[3 * v + 2]);
      }
    }
    write_file(*this / name, text);
  }
};

TEST(LearnedProgram, TrainReportsWhatWasLearned) {
  const Scene scene;
  const Outcome trained =
      scene.run({"train", "poses.npz", "-o", "a.model", "--modes", "2", "--key-points", "0.1"});
  EXPECT_EQ(trained.code, 0) << trained.err;
  for (const char* part : {"subspace                PCA, 2 modes  (", "% of the vertices, ",
                           "clusters of poses ", "certificates ", "projection error        mean ",
                           "cueing error            mean ", "leave-one-out error     mean ", " %)"}) {
    EXPECT_THAT(trained.out, HasSubstr(part));
  }
  const Outcome shown = scene.run({"info", "a.model", "--json", "a.json"});
  EXPECT_EQ(shown.code, 0);
  const json learned = json::parse(read_file(scene / "a.json"))["learned"];
  EXPECT_EQ(learned["modes"], 2);
  EXPECT_EQ(learned["poses"].size(), 6u);
  EXPECT_LE(learned["key_points"].size(), 30u);
  EXPECT_GT(learned["poses"][5]["leave_one_out"]["projection"]["mean"],
            learned["poses"][5]["trained"]["projection"]["mean"]);
  EXPECT_GT(learned["poses"][0]["trained"]["projection"]["mean_share"], 0);
  EXPECT_GT(learned["regions"].size(), 3u);
  const Outcome text = scene.run({"info", "a.model"});
  EXPECT_THAT(text.out, HasSubstr("leave-one-out  cluster"));
  EXPECT_THAT(text.out, HasSubstr("regions of largest leave-one-out error"));
}

TEST(LearnedProgram, LearningCanBeLeftOut) {
  const Scene scene;
  EXPECT_THAT(scene.run({"train", "poses.npz", "-o", "a.model", "--no-learning"}).out,
              HasSubstr("learned                 nothing: not requested\n"));
  EXPECT_THAT(scene.run({"train", "poses.npz", "--frames", ":2", "-o", "b.model"}).out,
              HasSubstr("learned                 nothing: too few poses\n"));
  EXPECT_THAT(scene.run({"train", "poses.npz", "-o", "c.model", "--subspace", "kernel-pca"}).out,
              HasSubstr("subspace                kernel PCA, "));
  EXPECT_THAT(scene.run({"info", "a.model"}).out, HasSubstr("learned                 nothing\n"));
}

TEST(LearnedProgram, PredictRebuildsTrainingPosesFromTracks) {
  const Scene scene;
  const auto poses = bending_twice(kSmallTubeToLearn, {{0, 0}, {0.5, 0}, {1, 0}, {-0.5, 0}, {-1, 0}, {2, 0}});
  scene.write_table("tracks.csv", *poses);
  const Outcome done =
      scene.run({"predict", "tube.model", "tracks.csv", "-o", "back.npz", "--truth", "poses.npz"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("frames                  6\n"));
  EXPECT_THAT(done.out, HasSubstr("from key points         mean "));
  EXPECT_THAT(done.out, HasSubstr("from all points         mean "));
  const auto back = open_motions(std::vector<std::string>{scene / "back.npz"});
  ASSERT_TRUE(back) << back.error().line();
  for (Index k = 0; k < 6; ++k) {
    const VertexDistance far = vertex_distance(frame_of(*back->front(), k), frame_of(*poses, k));
    EXPECT_LT(far.worst, 1e-3) << k;  // the tube is 6 long
  }
}

TEST(LearnedProgram, PredictWritesAndComparesWholeMotions) {
  const Scene scene;
  const Outcome compared = scene.run({"predict", "tube.model", "run.npz", "--frames", "1:"});
  EXPECT_EQ(compared.code, 0) << compared.err;
  EXPECT_THAT(compared.out, HasSubstr("frames                  2\n"));
  EXPECT_THAT(compared.out, HasSubstr(" in frame 1\n"));
  EXPECT_EQ(scene.run({"predict", "tube.model", "run.npz", "-o", "a.obj", "--quiet"}).out, "");
  EXPECT_EQ(scene.run({"predict", "tube.model", "run.npz", "-o", "a.ply", "--frames", "2"}).code, 0);
  EXPECT_EQ(scene.run({"predict", "tube.model", "a.obj", "a.pc2"}).code, 0);
  EXPECT_TRUE(open_motions(std::vector<std::string>{scene / "a.ply"}));
}

TEST(LearnedProgram, HelpTeaches) {
  const Scene scene;
  const Outcome help = scene.run({"predict", "--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.out, HasSubstr("Examples:"));
}

TEST(LearnedProgram, MistakesGetOneLineAndLeaveNoFile) {
  const Scene scene;
  ASSERT_EQ(scene.run({"train", "poses.npz", "-o", "bare.model", "--no-learning", "--quiet"}).code, 0);
  write_file(scene / "short.csv", "0,0,1,2,3\n");
  const auto before = scene.names();
  const std::vector<std::pair<std::vector<std::string>, std::string>> mistakes = {
      {{"train", "poses.npz", "-o", "a.model", "--energy", "1.5"},
       "--energy: 1.5 is not a share of the variance"},
      {{"train", "poses.npz", "-o", "a.model", "--key-points", "0"}, "--key-points: 0 is not a share"},
      {{"train", "poses.npz", "-o", "a.model", "--subspace", "lda"}, "--subspace: 'lda' is not known"},
      {{"train", "poses.npz", "-o", "a.model", "--modes", "-1"}, "--modes"},
      {{"predict"}, "MODEL"},
      {{"predict", "tube.model"}, "KEYPOINTS: is missing"},
      {{"predict", "bare.model", "run.npz"}, "bare.model: has learned no shapes; train it again"},
      {{"predict", "tube.model", "short.csv"}, "short.csv: lacks key points, for example in frame 0"},
      {{"predict", "tube.model", "other.npz"}, "tube.model: is a model of another mesh"},
      {{"predict", "tube.model", "run.npz", "run.npz"}, "are 2 motions; give one"},
      {{"predict", "tube.model", "run.npz", "--truth", "run.npz"}, "--truth: is given, but"},
      {{"predict", "tube.model", "run.npz", "-o", "a.xyz"}, "a.xyz: is not a format that is written here"},
      {{"predict", "tube.model", "run.npz", "-o", "a.ply"}, "a.ply: is PLY, which holds one frame"},
      {{"predict", "tube.model", "run.npz", "--frames", "9:"}, "--frames: selects none"},
      {{"predict", "tube.model", "short.csv", "-o", "a.npz", "--weld"},
       "--frames, --fps, --weld, --separate, --sequence and --clip"},
      {{"predict", "tube.model", "poses.npz", "-o", "no/where.obj"}, "no/where.obj"},
      {{"predict", "missing.model", "run.npz"}, "missing.model"}};
  for (const auto& [arguments, said] : mistakes) {
    expect_one_line_error(scene.run(arguments), said);
  }
  EXPECT_EQ(scene.names(), before);
}

}  // namespace
}  // namespace foldproof
