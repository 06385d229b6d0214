#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "base/duration.h"
#include "base/stopwatch.h"
#include "base/try.h"
#include "commands.h"
#include "learned_text.h"
#include "options.h"
#include "progress_bar.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kLearningGroup = "What is learned about shapes (3 poses or more)";

constexpr const char* kTrainFooter = R"(  pose.obj                        a single pose
Several motions are more poses of the same mesh: same triangles, same order. What they do to the mesh matters, not how
long they are: give poses in which it bends as far as it ever will. Poses in which it touches or crosses itself are fine.

The model holds charts, which prove that parts of the mesh do not touch themselves while they stay near a pose it was
trained on. They make 'check' faster; no model, however poor, changes an answer. It also holds what is learned about the
mesh's shapes: a subspace, key points, clusters of poses, and the reconstruction errors, as distances of vertices:

  projection error     between a training pose and its reconstruction in the subspace
  cueing error         what reconstruction from key points alone adds to that
  leave-one-out error  between a training pose and its reconstruction from what the other poses teach (with kernel PCA
                       too, in a linear subspace)

Examples:
  foldproof train walk.glb -o body.model               learn from all frames (the 16 that differ most)
  foldproof train poses/ walk.glb -o body.model        from separate poses and a motion
  foldproof train walk.glb --frames ::10 -o b.model    from every tenth frame
  foldproof train walk.glb --references 40 -o b.model  a larger model that proves a little more
  foldproof check run.glb --model body.model           use it
  foldproof info body.model                            show what it holds
  foldproof predict body.model tracks.csv -o run.npz   reconstruct shapes from key points)";

struct TrainArguments {
  std::vector<std::string> poses;
  std::string model;
  MotionOptions motion = pose_options();
  Index references = 0, random_poses = 0;
  LearnSettings learning;
  std::string subspace = "pca";
  std::optional<double> energy, key_points;
  bool no_learning = false;
  int threads = 0;
  bool quiet = false;
  FileArguments files;
};

std::string summary(const TrainArguments& a, const Model& model, double milliseconds) {
  const ModelSummary s = summarize(model);
  std::error_code unknown;
  const auto bytes = static_cast<double>(std::filesystem::file_size(a.model, unknown));
  const std::uint64_t triangles = model.hierarchy()->triangles().size();
  std::string text;
  const auto row = [&](const char* label, const std::string& value) {
    text += fmt::format("{:<24}{}\n", label, value);
  };
  row("triangles", grouped(triangles));
  row("poses", fmt::format("{}  ({})", grouped(model.poses.size()), counted(s.references, "reference")));
  row("charts", grouped(model.chart_count()));
  if (!unknown) {
    row("size", fmt::format("{:.3g} MB  ({:.3g} bytes per triangle and reference)", bytes / 1e6,
                            bytes / static_cast<double>(triangles) / s.references));
  }
  row("time", duration(milliseconds));
  row("proven in these poses",
      fmt::format("{:.1f} % of leaves and of pairs of neighboring leaves", 100 * s.proven));
  return text + learned_summary(model);
}

Result<std::vector<TrainPose>> poses_of(Motions motions, const FrameRange& range) {
  std::vector<TrainPose> poses;
  for (const auto& motion : motions) {
    for (const Index frame : select_frames(range, motion->frame_count()))
      poses.push_back({motion.get(), frame});
  }
  if (!poses.empty()) return poses;
  return fail(ErrorCode::InvalidArgument, "--frames", "selects none",
              "select more; frames count from 0 and the end of A:B is not included");
}

Result<TrainSettings> train_settings_of(const TrainArguments& a) {
  TrainSettings settings{.references = a.references,
                         .random_poses = a.random_poses,
                         .learn = !a.no_learning,
                         .learning = a.learning};
  LearnSettings& learning = settings.learning;
  if (a.subspace != "pca" && a.subspace != "kernel-pca") {
    return fail(ErrorCode::InvalidArgument, "--subspace", fmt::format("'{}' is not known", a.subspace),
                "give pca or kernel-pca");
  }
  if (a.subspace == "kernel-pca") learning.subspace = SubspaceKind::KernelPca;
  const auto is_share = [](double x) { return x > 0 && x <= 1; };
  if (a.energy && !is_share(*a.energy)) {
    return fail(ErrorCode::InvalidArgument, "--energy",
                fmt::format("{} is not a share of the variance", *a.energy),
                "give a number above 0 and at most 1");
  }
  if (a.energy) learning.size.energy = *a.energy;
  if (a.key_points && !is_share(*a.key_points)) {
    return fail(ErrorCode::InvalidArgument, "--key-points",
                fmt::format("{} is not a share of the vertices", *a.key_points),
                "give a number above 0 and at most 1");
  }
  if (a.key_points) {
    learning.key_points.max_share = *a.key_points;
    learning.key_points.first_share = *a.key_points / 2;
  }
  return settings;
}

Result<int> train(const TrainArguments& a) {
  Stopwatch watch;
  const auto range = FOLDPROOF_TRY(frame_range_of(a.motion));
  const auto settings = FOLDPROOF_TRY(train_settings_of(a));
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));
  FOLDPROOF_TRY(a.files.check());
  const auto motions = FOLDPROOF_TRY(read_motions(a.poses, a.motion.read, a.quiet));
  const auto poses = FOLDPROOF_TRY(poses_of(motions, range));

  const std::atomic<bool>& interrupted = watch_for_interrupt();
  ProgressBar bar(!a.quiet);
  TrainHooks hooks;
  std::string stage;
  double done = 0;
  hooks.stage = [&](const std::string& what) {
    stage = what;
    done > 0 ? bar.show(done, stage) : bar.begin(stage);
  };
  hooks.progress = [&](double share) {
    done = share;
    bar.show(done, stage);
  };
  hooks.cancel = &interrupted;
  const auto model = train_model(poses, settings, hooks);
  bar.clear();
  if (!model && interrupted) {
    print_error({"interrupted", "training was not finished", "no model was written"});
    return kExitInterrupted;
  }
  if (!model) return tl::unexpected(model.error());
  FOLDPROOF_TRY(save_model(*model, a.model));
  if (!a.quiet) print_output(summary(a, *model, watch.lap()));
  return kExitClean;
}

}  // namespace

Command add_train(CommandLine& program) {
  const Subcommand command =
      program.add_subcommand("train", "Make a model from poses of a mesh, which makes its checks faster");
  command.footer(fmt::format("{}{}", kMotionHelp, kTrainFooter));
  const auto a = std::make_shared<TrainArguments>();
  a->files
      .reads(command.add_option("POSES", a->poses, "The poses to train on: motions of one mesh (see below)"))
      .type_name("")
      .required();
  a->files.writes(command.add_option("-o,--output", a->model, "The model to write"))
      .type_name("FILE")
      .required();
  command
      .add_option("--references", a->references,
                  "Build charts in the N poses that differ most [all, at most 16]")
      .type_name("N");
  command
      .add_option("--random-poses", a->random_poses,
                  "Also build charts in N random poses of the learned subspace, for when poses are few [0]")
      .type_name("N");
  command.add_option("--modes", a->learning.size.modes, "Modes of the subspace [as many as the energy needs]")
      .type_name("N")
      .group(kLearningGroup);
  command.add_option("--energy", a->energy, "Share of the variance that the subspace keeps [0.999]")
      .type_name("SHARE")
      .group(kLearningGroup);
  command.add_option("--subspace", a->subspace, "kernel-pca keeps shapes near the poses [pca]")
      .type_name("pca|kernel-pca")
      .group(kLearningGroup);
  command.add_option("--key-points", a->key_points, "Key points, at most, as a share of the vertices [0.04]")
      .type_name("SHARE")
      .group(kLearningGroup);
  command.add_flag("--no-learning", a->no_learning, "Only build charts").group(kLearningGroup);
  add_motion_options(command, a->motion);
  add_threads_option(command, a->threads,
                     "At most N threads; the model is the same for any number [all cores]");
  command.add_flag("-q,--quiet", a->quiet, "Print nothing but errors");
  return [a] { return train(*a); };
}

}  // namespace foldproof
