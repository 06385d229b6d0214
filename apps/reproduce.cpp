#include "reproduce.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>

#include "base/parallel.h"
#include "commands.h"
#include "options.h"
#include "terminal.h"

namespace foldproof {
namespace {

using namespace reproduce;
namespace fs = std::filesystem;

constexpr const char* kFooter =
    R"(Makes the experiments of "Efficient Culling Criteria for Continues Collision Detection Using a Fast Statistical
Analysis Method" (2015) as pictures and tables: key points (its Fig. 2 and 3), poses and prediction (4, 5), a limb bent
inwards (6), contact within an object (7, 8), rebuilt meshes with their errors (9), and what it does not show: speed,
culling and misses of each mode against plain hierarchies.

Without --data everything is done on two meshes that the program generates. DIR/index.md tells what came out; read it
first. Beside it stand the pictures (PNG) and the trained models.

Examples:
  foldproof reproduce -o out                  a minute or two
  foldproof reproduce -o out --quick          on coarse meshes, some seconds: to try it
  foldproof reproduce -o out --data data      with the lion, the hand, the horse, the elephant: what is in data/
                                              (docs/reproduction.md says where files belong))";

struct ReproduceArguments {
  std::string directory, data;
  bool force = false, quick = false, quiet = false;
  int threads = 0;
  FileArguments files;
};

/// Error: the directory holds something.
Result<void> require_empty(const ReproduceArguments& a) {
  std::error_code error;
  if (!a.force && fs::is_directory(a.directory, error) && !fs::is_empty(a.directory, error))
    return fail(a.directory, "is not empty",
                "name another directory, or add --force to write over what is in it");
  return {};
}

Result<void> make_directory(const ReproduceArguments& a) {
  std::error_code error;
  fs::create_directories(a.directory, error);
  if (error)
    return fail(a.directory, "cannot be made: " + error.message(), "check the path and its permissions");
  return {};
}

/// What one subject gives, by section of the page.
struct Chapter {
  std::string source, table;
  std::string poses, prediction, keys, bent, collision, rebuilt;
};

std::string with_pictures(const Figure& figure) {
  std::string text;
  for (const std::string& file : figure.files)
    text += fmt::format("![{}]({})\n\n", file.substr(0, file.rfind('.')), file);
  text += figure.text;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.empty() ? text : text + "\n\n";
}

/// Runs the experiments and collects the page.
class Reproduction {
 public:
  Reproduction(const ReproduceArguments& a, const std::atomic<bool>& interrupted)
      : a_(a), bar_(!a.quiet), interrupted_(interrupted), figures_(a.directory) {}

  Result<std::string> run(std::vector<Subject>& subjects) {
    parts_ = subjects.size() + 1;
    std::vector<Chapter> chapters;
    for (Subject& subject : subjects) {
      auto chapter = experiment(subject);
      if (!chapter) return tl::unexpected(chapter.error());
      chapters.push_back(std::move(*chapter));
      ++done_;
    }
    show(0, "the direction that is missing");
    const auto missing = figures_.missing_direction(size(), hooks("the direction that is missing"));
    if (!missing) return tl::unexpected(missing.error());
    bar_.clear();
    return page(subjects, chapters, with_pictures(*missing));
  }
  Size size() const { return a_.quick ? Size::Quick : Size::Full; }
  void clear() { bar_.clear(); }

 private:
  Result<Chapter> experiment(Subject& subject) {
    const std::string training = "training on " + subject.id;
    std::vector<TrainPose> poses;
    for (Index k = 0; k < subject.poses->frame_count(); ++k) poses.push_back({subject.poses.get(), k});
    TrainHooks train_hooks;
    train_hooks.progress = [&](double part) { show(0.4 * part, training); };
    train_hooks.cancel = &interrupted_;
    const auto model = train_model(poses, {}, train_hooks);
    if (!model) return tl::unexpected(model.error());
    const std::string path = (fs::path(a_.directory) / (subject.id + ".model")).string();
    if (const auto saved = save_model(*model, path); !saved) return tl::unexpected(saved.error());

    const auto measured = measure(subject, *model, hooks("measuring " + subject.id));
    if (!measured) return tl::unexpected(measured.error());
    Chapter chapter;
    chapter.source = subject.source;
    chapter.table = table_of(*measured);
    if (!subject.pictures) return chapter;
    if (!model->learned)
      return fail(subject.poses->name(), "teaches nothing: " + model->not_learned, "give more poses");
    if (const auto drawn = draw(subject, *model, measured->worst, chapter); !drawn)
      return tl::unexpected(drawn.error());
    return chapter;
  }

  Result<void> draw(Subject& subject, const Model& model, const WorstStep& worst, Chapter& chapter) {
    struct Job {
      std::string* text;
      std::function<Result<Figure>()> make;
    };
    const std::vector<Job> jobs{{&chapter.keys, [&] { return figures_.key_points(subject, model); }},
                                {&chapter.poses, [&] { return figures_.training_poses(subject); }},
                                {&chapter.prediction, [&] { return figures_.prediction(subject, model); }},
                                {&chapter.bent, [&] { return figures_.bent(subject, model); }},
                                {&chapter.collision, [&] { return figures_.collision(subject, worst); }},
                                {&chapter.rebuilt, [&] { return figures_.rebuilt(subject, model); }}};
    for (const Job& job : jobs) {
      if (interrupted_) return fail("interrupted", "drawing was not finished", "start again");
      show(0.95, "drawing " + subject.id);
      const auto figure = job.make();
      if (!figure) return tl::unexpected(figure.error());
      *job.text = with_pictures(*figure);
    }
    return {};
  }

  Hooks hooks(const std::string& what) {
    return {[this, what](double part, const std::string& detail) {
              show(0.4 + 0.5 * part, what + ": " + detail);
            },
            &interrupted_};
  }
  void show(double part, const std::string& text) {
    bar_.show((static_cast<double>(done_) + part) / static_cast<double>(parts_), text);
  }

  std::string page(const std::vector<Subject>& subjects, const std::vector<Chapter>& chapters,
                   const std::string& missing) const {
    std::string text = fmt::format(
        "# Reproduction\n\nThe experiments of \"Efficient Culling Criteria for Continues Collision Detection "
        "Using a Fast "
        "Statistical Analysis Method\" (2015), done again by foldproof {}.{}\n\n## What was used\n\n",
        version(), a_.quick ? " Coarse meshes (--quick): to try it, not to quote it." : "");
    for (std::size_t k = 0; k < subjects.size(); ++k) {
      const Topology& mesh = subjects[k].motion->topology();
      text += fmt::format("* **{}**: {} vertices, {} triangles. {}\n", subjects[k].name,
                          grouped(mesh.vertex_count()), grouped(mesh.triangles().size()), chapters[k].source);
    }
    text += "\n";
    const auto section = [&](const char* heading, std::string Chapter::*part, const char* only) {
      text += fmt::format("## {}\n\n", heading);
      for (std::size_t k = 0; k < subjects.size(); ++k) {
        if (!*only || subjects[k].id == only) text += chapters[k].*part;
      }
    };
    section("Key points (Fig. 2 and 3)", &Chapter::keys, "");
    section("Poses of a cylinder (Fig. 4)", &Chapter::poses, "cylinder");
    section("A predicted cylinder (Fig. 5)", &Chapter::prediction, "cylinder");
    section("A limb bent inwards (Fig. 6)", &Chapter::bent, "");
    section("Contact within an object (Fig. 7 and 8)", &Chapter::collision, "");
    section("Rebuilt from all points, and from key points (Fig. 9)", &Chapter::rebuilt, "");
    text += "## A direction without an example\n\n" + missing;
    return text + speed(subjects, chapters);
  }

  std::string speed(const std::vector<Subject>& subjects, const std::vector<Chapter>& chapters) const {
    std::string text = fmt::format(
        "## Speed, culling and misses\n\nThe table that the paper lacks. Every mode answers the same steps. "
        "Milliseconds are the median of a step's complete answer, on {}; leaf pairs are the pairs of leaves "
        "whose features are tested, and *removed* is the share that plain hierarchies test and this mode "
        "does "
        "not, pairs that truly collide included. The first step is left out of both. *Missed* counts "
        "colliding "
        "pairs that plain hierarchies find and this mode does not, over all steps; a proven mode must have "
        "none. *Extra* counts the opposite.\n\n*Paper* is what the paper does: certificates are predicted "
        "from key points and believed, calibrated on poses held out in training to a miss rate: the share of "
        "what is not proven that is believed; 100 % believes all that is above the threshold. It is "
        "statistical and may miss collisions. *Reduced* answers from the coordinates in the subspace alone "
        "and "
        "computes only vertices of leaves that it must test. It is made for shapes that stay near a centre "
        "without contact; these motions do not, and its boxes are looser.\n\n",
        counted(a_.threads > 0 ? static_cast<std::uint64_t>(a_.threads)
                               : static_cast<std::uint64_t>(thread_count()),
                "thread"));
    for (std::size_t k = 0; k < subjects.size(); ++k)
      text += fmt::format("### {}\n\n{}\n", subjects[k].name, chapters[k].table);
    return text;
  }

  const ReproduceArguments& a_;
  ProgressBar bar_;
  const std::atomic<bool>& interrupted_;
  Figures figures_;
  std::size_t done_ = 0, parts_ = 1;
};

Result<void> write_page(const std::string& path, const std::string& text) {
  auto file = FileWriter::open(path);
  if (!file) return tl::unexpected(file.error());
  if (auto done = file->write(text); !done) return done;
  return file->commit();
}

Result<int> reproduce_all(const ReproduceArguments& a) {
  const auto start = std::chrono::steady_clock::now();
  std::optional<ThreadLimit> limit;
  if (const auto ok = limit_threads(a.threads, limit); !ok) return tl::unexpected(ok.error());
  if (const auto ok = a.files.check(); !ok) return tl::unexpected(ok.error());
  if (!a.data.empty() && !fs::is_directory(a.data))
    return fail(a.data, "is no directory", "name the one that holds lion-poses/, hand/ and so on");
  if (const auto ok = require_empty(a); !ok) return tl::unexpected(ok.error());
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  Reproduction reproduction(a, interrupted);
  std::vector<Subject> subjects = generated_subjects(reproduction.size());
  if (!a.data.empty()) {
    auto more = subjects_in(a.data);
    if (!more) return tl::unexpected(more.error());
    if (more->empty())
      return fail(a.data, "holds nothing that is known", "see docs/reproduction.md for what belongs there");
    for (Subject& subject : *more) subjects.push_back(std::move(subject));
  }
  if (const auto made = make_directory(a); !made) return tl::unexpected(made.error());
  const auto text = reproduction.run(subjects);
  reproduction.clear();
  if (!text && interrupted) {
    print_error({"interrupted", "not all was made",
                 fmt::format("{} holds what is finished, without index.md", a.directory)});
    return kExitInterrupted;
  }
  if (!text) return tl::unexpected(text.error());
  const std::string page = (fs::path(a.directory) / "index.md").string();
  if (const auto done = write_page(page, *text); !done) return tl::unexpected(done.error());
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (!a.quiet) print_output(fmt::format("{} tells what came out ({:.3g} s)\n", page, seconds.count()));
  return kExitClean;
}

}  // namespace

Command add_reproduce(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("reproduce", "Make the paper's experiments as pictures and tables");
  command->footer(kFooter);
  const auto a = std::make_shared<ReproduceArguments>();
  a->files
      .writes(
          command->add_option("-o,--output", a->directory, "Where all of it goes; made if it is not there"),
          FileArguments::Output::Directory)
      ->type_name("DIR")
      ->required();
  a->files
      .reads(command->add_option("--data", a->data, "Meshes to use besides the generated ones"),
             FileArguments::Input::Library)
      ->type_name("DIR");
  command->add_flag("--force", a->force, "Write into a directory that is not empty");
  command->add_flag("--quick", a->quick, "Generate coarse meshes and short motions");
  add_threads_option(*command, a->threads, "At most N threads [all cores]");
  command->add_flag("--quiet", a->quiet, "Print nothing but errors");
  return [a] { return reproduce_all(*a); };
}

}  // namespace foldproof
