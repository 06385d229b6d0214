#include <fmt/format.h>

#include "commands.h"
#include "foldproof/model.h"
#include "learned_text.h"
#include "options.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kFooter =
    R"(With a MOTION of the mesh: the frame that the model can tell least, then the one that it and the model still cannot tell,
and so on. Add these frames to the training poses.

Without one there is nothing to go by but the training poses themselves. A direction without any example cannot be
seen in them; what can be seen is where they are thin:
  one example  only one pose shows it: written is a pose half way to what the others know. Add poses like it.
  one-sided    poses go one way along a mode, and hardly the other: written is the other side, as far. If the mesh can
               move that way, add such a pose; if it cannot, nothing is missing.

Examples:
  foldproof suggest body.model run.glb               which frames of the run to train on
  foldproof suggest body.model run.glb -o pose.obj   write the first of them
  foldproof suggest body.model -o pose.ply           from the training poses alone)";

struct SuggestArguments {
  std::string model, output;
  std::vector<std::string> motion;
  MotionOptions options;
  Index count = 3;
  int threads = 0;
  bool quiet = false;
  FileArguments files;
};

std::string what(const Suggestion& s, const Model& model) {
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

const char* nothing(bool frames) {
  return frames ? "The model can tell every frame"
                : "No direction has a single example, and no mode leans to one side";
}

std::string table(const std::vector<Suggestion>& suggestions, const Model& model, bool frames) {
  const double size = model.learned->size;
  if (suggestions.empty()) return std::string(nothing(frames)) + ".\n";
  std::string text = fmt::format("{:>22}{:>22}{:>10}{}  what\n", "unknown, mean", "worst vertex", "there",
                                 frames ? fmt::format("{:>22}", "left after it, mean") : "");
  for (const Suggestion& s : suggestions) {
    text += fmt::format("{:>22}{:>22}{:>10}{}  {}\n", distance_text(s.distance.mean, size),
                        distance_text(s.distance.worst, size), s.distance.worst_vertex,
                        frames ? fmt::format("{:>22}", distance_text(s.left, size)) : "", what(s, model));
  }
  return text;
}

Result<std::vector<Suggestion>> find(const SuggestArguments& a, const Model& model) {
  if (a.motion.empty()) return suggest_poses(*model.learned, a.count);
  const auto range = frame_range_of(a.options);
  if (!range) return tl::unexpected(range.error());
  const auto motion = open_motion_of(model, a.motion, a.options.read);
  if (!motion) return tl::unexpected(motion.error());
  const auto frames = select_frames(*range, (*motion)->frame_count());
  if (frames.empty()) return fail("--frames", "selects none", "select more; frames count from 0");
  ProgressBar bar(!a.quiet);
  LearnHooks hooks;
  hooks.progress = [&](double part) { bar.show(part, "looking at " + counted(frames.size(), "frame")); };
  hooks.cancel = &watch_for_interrupt();
  return suggest_frames(*model.learned, **motion, frames, a.count, hooks);
}

Result<int> suggest(const SuggestArguments& a) {
  std::optional<ThreadLimit> limit;
  if (const auto ok = limit_threads(a.threads, limit); !ok) return tl::unexpected(ok.error());
  if (a.count < 1) return fail("--count", "is 0", "ask for at least one");
  if (const auto ok = a.files.check(); !ok) return tl::unexpected(ok.error());
  const auto model = load_learned_model(a.model);
  if (!model) return tl::unexpected(model.error());
  const auto suggestions = find(a, *model);
  if (!suggestions && watch_for_interrupt()) {
    print_error({"interrupted", "not all frames were looked at", "nothing was written"});
    return kExitInterrupted;
  }
  if (!suggestions) return tl::unexpected(suggestions.error());
  if (!a.output.empty()) {
    if (suggestions->empty())
      return fail(a.output, fmt::format("is not written: {}", nothing(!a.motion.empty())),
                  "there is no pose to suggest");
    const auto pose =
        memory_motion("suggestion", model->hierarchy()->topology(), {suggestions->front().positions});
    if (const auto done = write_motion(a.output, *pose); !done) return tl::unexpected(done.error());
  }
  if (!a.quiet) print_output(table(*suggestions, *model, !a.motion.empty()));
  return kExitClean;
}

}  // namespace

Command add_suggest(CLI::App& program) {
  CLI::App* command = program.add_subcommand("suggest", "Say which further pose would teach a model most");
  command->footer(kFooter);
  const auto a = std::make_shared<SuggestArguments>();
  FileArguments& files = a->files;
  files.reads(command->add_option("MODEL", a->model, "A file that 'foldproof train' wrote"))
      ->type_name("")
      ->required();
  files.reads(command->add_option("MOTION", a->motion, "A motion that the model is to know"))->type_name("");
  files
      .writes(command->add_option("-o,--output", a->output, "Write the first pose: .obj, .ply or .npz"),
              FileArguments::Output::Motion)
      ->type_name("FILE");
  command->add_option("--count", a->count, "How many, at most [3]")->type_name("N");
  add_motion_options(*command, a->options);
  add_threads_option(*command, a->threads, "At most N threads [all cores]");
  command->add_flag("--quiet", a->quiet, "Print nothing but errors");
  return [a] { return suggest(*a); };
}

}  // namespace foldproof
