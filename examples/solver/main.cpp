// A cloth falls on a soft ball and folds, or soft balls on each other, or a rod is twisted: an implicit
// solver that steps as far as Foldproof says.
#include <charconv>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "foldproof/io.h"
#include "implicit_euler.h"

namespace {

using namespace example;

constexpr const char* kUsage =
    "usage: example_cloth_solver [--scene cloth | pile | rod] [--steps N] [--cloth N] [--ball N] [--around "
    "N]\n"
    "                            [--look-every N] [-o FILE.npz]\n"
    "\n"
    "cloth: N x N vertices (default 32) that fall on a soft ball (an icosahedron quartered N times, default "
    "3).\n"
    "pile: six such balls that fall into a bowl. rod: N vertices around (default 16), twisted until it "
    "winds\n"
    "around itself.\n"
    "Prints the share of its time that collision detection takes. Every step is checked; every N-th pose\n"
    "(default 10) is looked at for intersections too. FILE.npz: the motion, for `foldproof view FILE.npz`.\n";

struct Options {
  int steps = 500, cloth = 32, ball = 3, around = 16, look_every = 10;
  std::string scene = "cloth", output;
};

bool read_number(std::string_view text, int& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() && number >= 1;
}

bool read_options(int count, char** arguments, Options& options) {
  for (int i = 1; i < count; i += 2) {
    if (i + 1 == count) return false;
    const std::string name = arguments[i];
    if (name == "-o" || name == "--scene") {
      (name == "-o" ? options.output : options.scene) = arguments[i + 1];
      continue;
    }
    int* number = name == "--steps"        ? &options.steps
                  : name == "--cloth"      ? &options.cloth
                  : name == "--ball"       ? &options.ball
                  : name == "--around"     ? &options.around
                  : name == "--look-every" ? &options.look_every
                                           : nullptr;
    if (number == nullptr || !read_number(arguments[i + 1], *number)) return false;
  }
  const bool known = options.scene == "cloth" || options.scene == "pile" || options.scene == "rod";
  return known && options.cloth >= 3 && options.cloth <= 500 && options.ball <= 6 && options.around >= 6 &&
         options.around <= 500;
}

Scene make(const Options& options) {
  if (options.scene == "pile") return pile_of_balls(options.ball);
  if (options.scene == "rod") return twisted_rod(static_cast<Index>(options.around));
  return cloth_on_ball(static_cast<Index>(options.cloth), options.ball);
}

// The floor does not collide with itself.
std::shared_ptr<const foldproof::CollisionMesh> collision_mesh(const Scene& scene) {
  std::vector<foldproof::Index> group(scene.vertex_count(), 0);
  for (foldproof::Index v = scene.floor_begin; v < group.size(); ++v) group[v] = 1;
  const std::array<foldproof::Index, 2> floor_with_itself{1, 1};
  foldproof::CollisionMeshSettings settings;
  if (scene.floor_begin < scene.vertex_count())
    settings.filter = foldproof::CollisionFilter::groups(group, std::span(&floor_with_itself, 1)).value();
  settings.points = false;  // what holds bodies open from inside
  return std::make_shared<const foldproof::CollisionMesh>(
      foldproof::CollisionMesh::make(scene.x, {}, scene.faces, settings).value());
}

bool write(const Scene& scene, std::vector<std::vector<double>> frames, const std::string& path) {
  auto topology = foldproof::Topology::make(scene.vertex_count(), scene.faces).value();
  auto motion = foldproof::memory_motion("a simulation", std::move(topology), std::move(frames));
  const auto written = foldproof::write_npz(path, *motion);
  if (!written) std::fprintf(stderr, "%s\n", written.error().line().c_str());
  return written.has_value();
}

void print_shares(const TimedChecker& checker, double seconds) {
  const double with = checker.seconds_with(), without = checker.seconds_without(),
               rest = seconds - with - without - checker.seconds_compared();
  std::printf("processor time, s: solver %.1f, collision with certificates %.1f, without %.1f\n", rest, with,
              without);
  std::printf("collision's share of the time: %.1f %% with certificates, %.1f %% without\n",
              100 * with / (rest + with), 100 * without / (rest + without));
}

}  // namespace

int main(int argument_count, char** arguments) {
  Options options;
  if (!read_options(argument_count, arguments, options)) return std::fputs(kUsage, stderr), 2;
  const Scene scene = make(options);
  TimedChecker checker(collision_mesh(scene));
  ImplicitEuler solver(scene, checker);
  std::vector<std::vector<double>> frames{scene.x};
  std::printf("%u vertices, %zu triangles, %zu springs\n", scene.vertex_count(), scene.faces.size(),
              scene.springs.size());

  const double start = processor_time();
  int newton_steps = 0, looked = 0, shortened = 0, bad = checker.intersects(scene.x);
  std::size_t most_contacts = 0;
  for (int step = 1; step <= options.steps; ++step) {
    const StepReport report = solver.step();
    newton_steps += report.newton_steps;
    most_contacts = std::max(most_contacts, report.contacts);
    bad += !report.collision_free;
    shortened += report.least_share < 1;
    if (step % options.look_every == 0) {
      ++looked;
      bad += checker.intersects(solver.positions());
    }
    if (step % 50 == 0) {
      std::printf("step %3d: %2d Newton steps, %5zu contacts, least share of a step %.2g\n", step,
                  report.newton_steps, report.contacts, report.least_share);
      std::fflush(stdout);
    }
    if (!options.output.empty()) frames.emplace_back(solver.positions().begin(), solver.positions().end());
  }
  const double seconds = processor_time() - start;

  std::printf(
      "%d steps, %d Newton steps, at most %zu contacts; in %d steps a Newton step was cut short of contact\n",
      options.steps, newton_steps, most_contacts, shortened);
  print_shares(checker, seconds);
  if (checker.disagreements() != 0)
    std::printf("%d answers differ without certificates\n", checker.disagreements());
  std::printf("%d of %d steps and %d poses are not free of intersections\n", bad, options.steps, looked);
  if (!options.output.empty() && !write(scene, std::move(frames), options.output)) return 2;
  return bad == 0 && checker.disagreements() == 0 ? 0 : 1;
}
