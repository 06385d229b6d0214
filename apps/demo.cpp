#include <fmt/format.h>

#include <filesystem>

#include "base/try.h"
#include "commands.h"
#include "demo_motions.h"
#include "foldproof/model.h"
#include "io/bytes.h"
#include "io/new_directory.h"
#include "options.h"
#include "progress_bar.h"
#include "terminal.h"
#include "write_glb.h"

namespace foldproof {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDemoFooter =
    R"(It writes a generated motion and the other files that the examples in Foldproof's help texts and documentation use, so
that these can be typed in that directory as they stand:
  walk.glb        two legs that walk, and brush against each other
  run.glb         the same with longer strides
  pose.obj        one pose, in which the legs cross
  body.npz        the motion of walk.glb as NPZ
  shirt.npz       a skirt around the legs, as a second object
  parts.txt       which part each triangle of the legs belongs to
  poses/          poses to train on
  body.model      the model that they give, with coordinates (p.csv) and tracks (tracks.csv) of walk.glb
  cloth/          the skirt as frames, an OBJ file each
  library/        motions to sweep

Examples:
  foldproof demo legs
  cd legs
  foldproof check walk.glb)";

struct DemoArguments {
  std::string directory;
  bool quiet = false;
};

/// One period of the gait.
std::vector<Stride> gait(Index frames, double swing, double narrow) {
  std::vector<Stride> strides;
  for (Index k = 0; k < frames; ++k)
    strides.push_back({0.12 + static_cast<double>(k) / (frames - 1), swing, narrow});
  return strides;
}

std::vector<Stride> walking_strides() { return gait(25, 0.45, 0.64); }

std::vector<Stride> training_strides() {
  std::vector<Stride> strides;
  for (const double narrow : {0.0, 0.2}) {
    for (const double swing : {0.3, 0.6}) {
      for (const double phase : {0.0, 0.25, 0.5, 0.75}) strides.push_back({phase, swing, narrow});
    }
  }
  return strides;
}

Result<void> write_motions(const fs::path& directory, Motion& walk) {
  for (const char* folder : {"poses", "cloth", "library"}) fs::create_directory(directory / folder);
  const auto run = legs("run", gait(17, 0.6, 0.6));
  const auto crossed = legs("pose", {{0, 0.4, 0.75}});
  const auto poses = legs("poses", training_strides());
  const auto shirt = skirt("shirt", walking_strides());
  const auto cloth = skirt("cloth", gait(5, 0.45, 0.5));
  const auto at = [&](const char* name) { return (directory / name).generic_string(); };
  FOLDPROOF_TRY(write_glb(at("walk.glb"), walk));
  FOLDPROOF_TRY(write_motion(at("body.npz"), walk));
  FOLDPROOF_TRY(write_glb(at("run.glb"), *run));
  FOLDPROOF_TRY(write_motion(at("pose.obj"), *crossed));
  FOLDPROOF_TRY(write_motion(at("shirt.npz"), *shirt));
  FOLDPROOF_TRY(write_motion(at("poses/pose_%02d.obj"), *poses));
  FOLDPROOF_TRY(write_motion(at("cloth/frame_%02d.obj"), *cloth));
  FOLDPROOF_TRY(write_motion(at("library/skirt.npz"), *shirt));
  FOLDPROOF_TRY(write_glb(at("library/run.glb"), *run));
  return io::write_file(at("parts.txt"), fmt::format("{}\n", fmt::join(leg_parts(), "\n")));
}

/// Trains on the poses; writes the model, and what it says of the walk.
Result<void> write_model(const fs::path& directory, Motion& walk, const TrainHooks& hooks) {
  const auto motion = legs("poses", training_strides());
  std::vector<TrainPose> poses;
  for (Index frame = 0; frame < motion->frame_count(); ++frame) poses.push_back({motion.get(), frame});
  const auto model = FOLDPROOF_TRY(train_model(poses, {}, hooks));
  FOLDPROOF_TRY(save_model(model, (directory / "body.model").generic_string()));

  // Tracks of all vertices, so that they fit whatever model is trained later.
  std::string tracks = "frame,vertex,x,y,z\n", coordinates;
  Eigen::VectorXd x(3 * Eigen::Index{walk.topology().vertex_count()});
  for (Index frame = 0; frame < walk.frame_count(); ++frame) {
    FOLDPROOF_TRY(walk.read_frame(frame, {x.data(), static_cast<std::size_t>(x.size())}));
    for (Eigen::Index v = 0; 3 * v < x.size(); ++v)
      tracks += fmt::format("{},{},{:.6g},{:.6g},{:.6g}\n", frame, v, x[3 * v], x[3 * v + 1], x[3 * v + 2]);
    const Eigen::VectorXd p = model.learned->pca.project(x);
    coordinates += fmt::format("{}\n", fmt::join(p.begin(), p.end(), ","));
  }
  FOLDPROOF_TRY(io::write_file((directory / "tracks.csv").generic_string(), tracks));
  return io::write_file((directory / "p.csv").generic_string(), coordinates);
}

Result<int> demo(const DemoArguments& a) {
  fs::path target(a.directory);
  if (!target.has_filename()) target = target.parent_path();  // "legs/"
  if (target.empty()) return fail(ErrorCode::InvalidArgument, "DIR", "names nothing", "name a new directory");
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(target, ignored)))
    return fail(ErrorCode::FileAccess, target.generic_string(), "is already there", "name a new directory");
  auto directory = FOLDPROOF_TRY(io::NewDirectory::open(target));
  const auto walk = legs("walk", walking_strides());
  FOLDPROOF_TRY(write_motions(directory.path(), *walk));
  ProgressBar bar(!a.quiet);
  TrainHooks hooks;
  hooks.progress = [&](double share) { bar.show(share, "training"); };
  hooks.cancel = &interrupted;
  FOLDPROOF_TRY(write_model(directory.path(), *walk, hooks));
  bar.clear();
  FOLDPROOF_TRY(directory.commit());
  if (!a.quiet)
    print_output(fmt::format(
        "Wrote a generated motion and its model into {0}. Now try:\n  foldproof check {0}/walk.glb\n"
        "  foldproof view {0}/walk.glb\n",
        target.generic_string()));
  return kExitClean;
}

}  // namespace

Command add_demo(CommandLine& program) {
  const Subcommand command =
      program.add_subcommand("demo", "Write a small motion and its model, to try everything with");
  command.footer(kDemoFooter);
  const auto a = std::make_shared<DemoArguments>();
  command.add_option("DIR", a->directory, "A new directory").type_name("").required();
  command.add_flag("-q,--quiet", a->quiet, "Print nothing but errors");
  return [a] { return demo(*a); };
}

}  // namespace foldproof
