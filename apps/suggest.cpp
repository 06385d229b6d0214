#include <fmt/format.h>

#include "base/try.h"
#include "commands.h"
#include "foldproof/model.h"
#include "interruptible_motion.h"
#include "learned_text.h"
#include "options.h"
#include "progress_bar.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kSuggestFooter =
    R"(With a MOTION of the mesh, it lists the frame that the model reconstructs worst, then the frame that is worst once the
first is added, and so on. Add these frames to the training poses.

Without one, it has only the training poses. They cannot show a direction that has no example, but they show where
examples are few:
  one example  only one pose shows a direction. The suggested pose is half way between it and its reconstruction from
               the other poses. Add poses like it.
  one-sided    along a mode, the poses go much farther to one side. The suggested pose goes equally far to the other. If
               the mesh can move that way, add such a pose; if it cannot, nothing is missing.

Errors and modes are those of the linear subspace, also where the model has kernel PCA.

Examples:
  foldproof suggest body.model run.glb               which frames of the run to train on
  foldproof suggest body.model run.glb -o worst.obj  write the first of them
  foldproof suggest body.model -o next.ply           from the training poses alone)";

struct SuggestArguments {
  std::string model, output;
  std::vector<std::string> motion;
  MotionOptions options = pose_options();
  Index count = 3;
  int threads = 0;
  bool quiet = false;
  FileArguments files;
};

std::string description(const Suggestion& s, const Model& model) {
  switch (s.why) {
    case Suggestion::Why::Frame:
      return fmt::format("frame {}", s.number);
    case Suggestion::Why::OneExample:
      return fmt::format("one example: {}", cell(model.poses[s.number].name));
    case Suggestion::Why::OneSided:
      return fmt::format("one-sided: mode {}", s.number);
  }
  return "";
}

const char* no_suggestion(bool frames) {
  return frames ? "The model represents every frame"
                : "No direction has only one example, and no mode is one-sided";
}

std::string suggestion_table(const std::vector<Suggestion>& suggestions, const Model& model, bool frames) {
  const double size = model.learned->size;
  if (suggestions.empty()) return std::string(no_suggestion(frames)) + ".\n";
  std::string text = fmt::format("{:>22}{:>22}{:>10}{}  pose\n", "error, mean", "error, worst", "at vertex",
                                 frames ? fmt::format("{:>22}", "mean once added") : "");
  for (const Suggestion& s : suggestions) {
    text += fmt::format("{:>22}{:>22}{:>10}{}  {}\n", distance_text(s.distance.mean, size),
                        distance_text(s.distance.worst, size), s.distance.worst_vertex,
                        frames ? fmt::format("{:>22}", distance_text(s.mean_after, size)) : "",
                        description(s, model));
  }
  return text;
}

Result<std::vector<Suggestion>> find(const SuggestArguments& a, const Model& model,
                                     const std::atomic<bool>& interrupted) {
  if (a.motion.empty()) return suggest_poses(*model.learned, a.count);
  const auto range = FOLDPROOF_TRY(frame_range_of(a.options));
  const auto motion = FOLDPROOF_TRY(open_motion_of(model, a.motion, a.options.read, a.quiet));
  const auto frames = select_frames(range, motion->frame_count());
  if (frames.empty()) {
    return fail(ErrorCode::InvalidArgument, "--frames", "selects none", "select more; frames count from 0");
  }
  ProgressBar bar(!a.quiet);
  LearnHooks hooks;
  hooks.progress = [&](double share) { bar.show(share, "reading " + counted(frames.size(), "frame")); };
  hooks.cancel = &interrupted;
  return suggest_frames(*model.learned, *motion, frames, a.count, hooks);
}

Result<int> suggest(const SuggestArguments& a) {
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));
  if (a.count < 1) return fail(ErrorCode::InvalidArgument, "--count", "is 0", "give at least 1");
  FOLDPROOF_TRY(a.files.check());
  const auto model = FOLDPROOF_TRY(load_learned_model(a.model));
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  const auto suggestions = find(a, model, interrupted);
  if (!suggestions && interrupted) {
    print_error({"interrupted", "not all frames were read", "nothing was written"});
    return kExitInterrupted;
  }
  if (!suggestions) return tl::unexpected(suggestions.error());
  if (!a.output.empty()) {
    if (suggestions->empty())
      return fail(ErrorCode::NotLearned, a.output,
                  fmt::format("is not written: {}", no_suggestion(!a.motion.empty())),
                  "there is no pose to suggest");
    const auto pose =
        memory_motion("suggestion", model.hierarchy()->topology(), {suggestions->front().positions});
    InterruptibleMotion motion(*pose, interrupted);
    FOLDPROOF_TRY(write_motion(a.output, motion));
  }
  if (!a.quiet) print_output(suggestion_table(*suggestions, model, !a.motion.empty()));
  return kExitClean;
}

}  // namespace

Command add_suggest(CommandLine& program) {
  const Subcommand command = program.add_subcommand("suggest", "Suggest poses to add to those of a model");
  command.footer(kSuggestFooter);
  const auto a = std::make_shared<SuggestArguments>();
  FileArguments& files = a->files;
  files.reads(command.add_option("MODEL", a->model, "A file that 'foldproof train' wrote"))
      .type_name("")
      .required();
  files.reads(command.add_option("MOTION", a->motion, "A motion that the model should represent"))
      .type_name("");
  files
      .writes(command.add_option("-o,--output", a->output, "Write the first pose: .obj, .ply or .npz"),
              FileArguments::Output::Motion)
      .type_name("FILE");
  command.add_option("--count", a->count, "How many, at most [3]").type_name("N");
  add_motion_options(command, a->options);
  add_threads_option(command, a->threads, "At most N threads [all cores]");
  command.add_flag("-q,--quiet", a->quiet, "Print nothing but errors");
  return [a] { return suggest(*a); };
}

}  // namespace foldproof
