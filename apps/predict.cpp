#include <fmt/format.h>

#include <filesystem>
#include <numeric>

#include "base/try.h"
#include "commands.h"
#include "foldproof/model.h"
#include "interruptible_motion.h"
#include "learned_text.h"
#include "options.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kPredictFooter =
    R"(KEYPOINTS gives the positions of the model's key points, frame by frame:
  tracks.csv  with the columns frame, vertex, x, y, z, rows in any order
  tracks.csv  or with x y z of every key point in a row, a row per frame
  tracks.npz  or with the array 'keypoints', frames x points x 3
  walk.glb    or a whole motion of the mesh, from which only the key points are read
Without vertex numbers, key points come in the order of --list-key-points.

With a whole motion, there or as --truth, it also prints errors: of the reconstruction from key points, and of that from
all points, which is the best in the subspace.

Examples:
  foldproof predict body.model --list-key-points         which vertices to track
  foldproof predict body.model tracks.csv -o walk.npz    reconstruct the mesh
  foldproof predict body.model walk.glb                  how well key points reconstruct this motion
  foldproof predict body.model tracks.csv --truth walk.glb -o walk.obj)";

struct PredictArguments {
  std::string model, output;
  std::vector<std::string> key_points, truth;
  MotionOptions motion = pose_options();
  bool list = false, quiet = false;
  int threads = 0;
  FileArguments files;
};

/// Whether the arguments name tracks, not a motion.
Result<bool> are_tracks(const std::vector<std::string>& arguments) {
  if (arguments.size() != 1) return false;
  const std::string extension = extension_of(arguments[0]);
  if (extension == ".npz") return npz_has_array(arguments[0], "keypoints");
  return extension == ".csv";
}

bool selects_or_reads_otherwise(const MotionOptions& motion) {
  return !motion.frames.empty() || motion.read.weld != Weld::ByFormat ||
         motion.read.mesh_files != pose_options().read.mesh_files || motion.read.fps != ReadOptions().fps ||
         !motion.read.clip.empty();
}

struct PredictInput {
  KeyPointTracks tracks;
  std::unique_ptr<Motion> truth;  ///< Null: nothing to compare with.
  std::vector<Index> frames;      ///< Of the truth.
};

Result<PredictInput> read_input(const PredictArguments& a, const Model& model) {
  const auto range = FOLDPROOF_TRY(frame_range_of(a.motion));
  const auto tracked = FOLDPROOF_TRY(are_tracks(a.key_points));
  PredictInput input;
  if (!tracked && !a.truth.empty()) {
    return fail(ErrorCode::InvalidArgument, "--truth",
                "is given, but the key points come from a whole motion already", "leave it out");
  }
  const auto& whole = tracked ? a.truth : a.key_points;
  if (whole.empty() && selects_or_reads_otherwise(a.motion)) {
    return fail(ErrorCode::InvalidArgument, "--frames, --fps, --weld, --separate, --sequence and --clip",
                "are about a whole motion, and there is none", "leave them out, or give --truth");
  }
  if (!whole.empty()) {
    input.truth = FOLDPROOF_TRY(open_motion_of(model, whole, a.motion.read, a.quiet));
    input.frames = select_frames(range, input.truth->frame_count());
    if (input.frames.empty()) {
      return fail(ErrorCode::InvalidArgument, "--frames", "selects none", "select more; frames count from 0");
    }
  }
  const auto& vertices = model.learned->key_points.vertices;
  input.tracks = FOLDPROOF_TRY(tracked ? read_key_point_tracks(a.key_points[0], vertices)
                                       : extract_tracks(*input.truth, vertices, input.frames));
  if (input.truth && input.tracks.frames != input.frames.size()) {
    return fail(ErrorCode::InvalidArgument, a.key_points[0],
                fmt::format("has {}, and {} of {} are to compare with", counted(input.tracks.frames, "frame"),
                            input.frames.size(), input.truth->name()),
                "choose them with --frames");
  }
  return input;
}

/// The error over all frames.
struct Comparison {
  double mean = 0;
  VertexDistance worst;
  Index worst_frame = 0;
  void add(const VertexDistance& d, Index frame, std::size_t frames) {
    mean += d.mean / static_cast<double>(frames);
    if (d.worst < worst.worst) return;
    worst = d;
    worst_frame = frame;
  }
  std::string text(double size) const {
    return fmt::format("mean {}, worst {} at vertex {} in frame {}", distance_text(mean, size),
                       distance_text(worst.worst, size), worst.worst_vertex, worst_frame);
  }
};

Result<std::string> compare(const PredictInput& input, Motion& predicted, const Predictor& predictor,
                            const std::atomic<bool>& interrupted) {
  Comparison keys, all;
  Eigen::VectorXd x(3 * Eigen::Index{predicted.topology().vertex_count()}), y(x.size());
  const auto numbers = [](Eigen::VectorXd& v) {
    return std::span(v.data(), static_cast<std::size_t>(v.size()));
  };
  for (Index k = 0; k < predicted.frame_count(); ++k) {
    if (interrupted) {
      return fail(ErrorCode::Interrupted, "interrupted", "the prediction was not finished", "run it again");
    }
    const Index frame = input.frames[k];
    FOLDPROOF_TRY(input.truth->read_frame(frame, numbers(x)));
    FOLDPROOF_TRY(predicted.read_frame(k, numbers(y)));
    keys.add(vertex_distance(x, y), frame, input.frames.size());
    all.add(vertex_distance(x, predictor.from_all_points(x)), frame, input.frames.size());
  }
  const double size = predictor.learned().size;
  std::string text = fmt::format("{:<24}{}\n", "from key points", keys.text(size));
  text += fmt::format("{:<24}{}\n", "from all points", all.text(size));
  if (all.mean > 0) {
    text += fmt::format("{:<24}{:.3g}\n", "ratio of the means", keys.mean / all.mean);
  }
  return text;
}

int report_interrupted(bool written) {
  print_error({"interrupted", written ? "while comparing" : "the prediction was not finished",
               written ? "the motion is written" : "nothing was written"});
  return kExitInterrupted;
}

Result<int> predict(const PredictArguments& a) {
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));
  FOLDPROOF_TRY(a.files.check());
  const auto model = FOLDPROOF_TRY(load_learned_model(a.model));
  if (a.list) {
    print_output(fmt::format("{}\n", fmt::join(model.learned->key_points.vertices, "\n")));
    return kExitClean;
  }
  if (a.key_points.empty())
    return fail(ErrorCode::InvalidArgument, "KEYPOINTS", "is missing",
                "'foldproof predict --help' shows what it may be");
  auto input = FOLDPROOF_TRY(read_input(a, model));
  if (!input.truth && a.output.empty()) {
    return fail(ErrorCode::InvalidArgument, "-o", "is missing",
                "name the file to write, or a motion to compare with: --truth");
  }
  const auto predictor = std::make_shared<const Predictor>(model.learned);
  const auto predicted =
      predicted_motion(a.key_points[0], model.hierarchy()->topology(), predictor, input.tracks);
  // From here on, an interrupt must not leave a half-written file behind.
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  if (!a.output.empty()) {
    InterruptibleMotion motion(*predicted, interrupted);
    const auto done = write_motion(a.output, motion);
    if (!done && interrupted) return report_interrupted(false);
    if (!done) return tl::unexpected(done.error());
  }
  if (a.quiet) return kExitClean;
  const auto& keys = model.learned->key_points.vertices;
  std::string text =
      fmt::format("{:<24}{}\n{:<24}{}  ({:.2g} % of the vertices)\n", "frames", grouped(input.tracks.frames),
                  "key points", grouped(keys.size()),
                  100.0 * static_cast<double>(keys.size()) / model.hierarchy()->topology().vertex_count());
  if (input.truth) {
    const auto compared = compare(input, *predicted, *predictor, interrupted);
    if (!compared && interrupted) return report_interrupted(!a.output.empty());
    if (!compared) return tl::unexpected(compared.error());
    text += *compared;
  }
  print_output(text);
  return kExitClean;
}

}  // namespace

Command add_predict(CommandLine& program) {
  const Subcommand command = program.add_subcommand("predict", "Reconstruct a mesh from its key points");
  command.footer(kPredictFooter);
  const auto a = std::make_shared<PredictArguments>();
  FileArguments& files = a->files;
  files.reads(command.add_option("MODEL", a->model, "A file that 'foldproof train' wrote"))
      .type_name("")
      .required();
  files.reads(command.add_option("KEYPOINTS", a->key_points, "Positions of the key points (see below)"))
      .type_name("");
  files
      .writes(command.add_option("-o,--output", a->output,
                                 "The motion to write: .npz, .obj with .pc2, .ply for one frame"),
              FileArguments::Output::Motion)
      .type_name("FILE");
  files.reads(command.add_option("--truth", a->truth, "A whole motion to compare with"))
      .type_name("MOTION")
      .expected(1, 2);
  command.add_flag("--list-key-points", a->list, "Print the vertices to track, and exit");
  add_motion_options(command, a->motion);
  add_threads_option(command, a->threads, "At most N threads [all cores]");
  command.add_flag("-q,--quiet", a->quiet, "Print nothing but errors");
  return [a] { return predict(*a); };
}

}  // namespace foldproof
