#include <fmt/format.h>

#include "base/try.h"
#include "commands.h"
#include "foldproof/model.h"
#include "interruptible_motion.h"
#include "options.h"
#include "progress_bar.h"
#include "report/repair_motions.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kSampleFooter =
    R"(The shapes are distributed as the training poses are: each mode of the subspace varies by the standard deviation that was
learned. A shape in which two triangles cross is refused, and another is drawn; or, with --repair, the nearest that was
found in which none cross is taken. No triangles cross in a shape that is
written: proven, and for the very numbers in the file.

Examples:
  foldproof sample body.model -o shapes.npz                     ten shapes, as the frames of a motion
  foldproof sample body.model -o shape_%04d.obj --count 100     a file for each
  foldproof sample body.model -o wild.npz --spread 1.5          farther from the mean than the training poses
  foldproof sample body.model -o other.npz --seed 2             other shapes; the same seed gives the same ones)";

struct SampleArguments {
  std::string model, output;
  SampleSettings settings;
  int threads = 0;
  bool quiet = false, repair = false;
  FileArguments files;
};

std::string summary(const SampleArguments& a, const Samples& samples) {
  const std::uint64_t kept = samples.shapes->frame_count(), refused = samples.drawn - kept;
  std::string text = row("shapes", grouped(kept));
  if (a.repair) text += row("repaired", grouped(samples.repaired));
  text += row("refused", fmt::format("{}  ({:.3g} % of {} drawn: they cross themselves)", grouped(refused),
                                     100 * static_cast<double>(refused) / static_cast<double>(samples.drawn),
                                     grouped(samples.drawn)));
  return text + row("written to", a.output) + "\n" +
         colored("No triangles cross in any of them, proven.", Tone::Good) + "\n";
}

// Replaces a shape by the nearest that touches nothing.
Result<bool> repair_shape(const std::shared_ptr<const Model>& model, std::span<double> x,
                          const std::atomic<bool>& interrupted) {
  std::vector<std::unique_ptr<Motion>> shape;
  shape.push_back(memory_motion(model->name, model->hierarchy()->topology(), {{x.begin(), x.end()}}));
  RepairRequest request;
  request.check.models = {model};
  request.repair.single_precision = true;
  request.repair.interrupted = [&] { return interrupted.load(); };
  const auto done = FOLDPROOF_TRY(repair_motions(shape, request));
  if (!done.report.free) return false;
  FOLDPROOF_TRY(done.motion(0)->read_frame(0, x));
  return true;
}

Result<int> sample(SampleArguments& a) {
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));
  FOLDPROOF_TRY(require_number("--spread", a.settings.spread, false));
  if (a.settings.count < 1) return fail(ErrorCode::InvalidArgument, "--count", "is 0", "give at least 1");
  FOLDPROOF_TRY(a.files.check());
  const auto model = std::make_shared<const Model>(FOLDPROOF_TRY(load_learned_model(a.model)));
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  if (a.repair) a.settings.repair = [&](std::span<double> x) { return repair_shape(model, x, interrupted); };
  ProgressBar bar(!a.quiet);
  TrainHooks hooks;
  hooks.progress = [&](double share) { bar.show(share, "drawing " + counted(a.settings.count, "shape")); };
  hooks.cancel = &interrupted;
  const auto samples = FOLDPROOF_TRY(sample_shapes(*model, a.settings, hooks));
  bar.clear();
  InterruptibleMotion shapes(*samples.shapes, interrupted);
  FOLDPROOF_TRY(write_motion(a.output, shapes));
  if (!a.quiet) print_output(summary(a, samples));
  return kExitClean;
}

}  // namespace

Command add_sample(CommandLine& program) {
  const Subcommand command =
      program.add_subcommand("sample", "Draw shapes from a model that do not cross themselves");
  command.footer(kSampleFooter);
  const auto a = std::make_shared<SampleArguments>();
  a->files.reads(command.add_option("MODEL", a->model, "A file that 'foldproof train' wrote"))
      .type_name("")
      .required();
  a->files
      .writes(command.add_option(
                  "-o,--output", a->output,
                  "What to write: .npz, .obj with .pc2; .obj or .ply with %04d in the name, a file per "
                  "shape"),
              FileArguments::Output::Motion)
      .type_name("FILE")
      .required();
  command.add_option("--count", a->settings.count, "How many shapes [10]").type_name("N");
  command.add_option("--seed", a->settings.seed, "Another number draws other shapes [1]").type_name("N");
  command.add_option("--spread", a->settings.spread, "Factor of the learned standard deviations [1]")
      .type_name("X");
  command.add_flag("--repair", a->repair, "Repair shapes that cross themselves instead of refusing them");
  add_threads_option(command, a->threads,
                     "At most N threads; the shapes are the same for any number [all cores]");
  command.add_flag("-q,--quiet", a->quiet, "Print nothing but errors");
  return [a] { return sample(*a); };
}

}  // namespace foldproof
