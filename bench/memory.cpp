#include "memory.h"

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>

#include <fmt/format.h>

#include "base/try.h"
#include "competitor.h"
#include "measure.h"

namespace foldproof::bench {
namespace {

/// A figure from /proc/self/status, in bytes.
double status_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  std::string word;
  double kibibytes = 0;
  while (status >> word)
    if (word == key + ":") status >> kibibytes;
  return kibibytes * 1024;
}

/// Sets the peak that the kernel remembers (VmHWM) back to what is resident now.
bool reset_peak() {
  malloc_trim(0);  // What reading the files left behind must not serve as unseen supply.
  std::ofstream refs("/proc/self/clear_refs");
  refs << "5" << std::flush;
  return refs.good();
}

struct LoadedStep {
  std::vector<double> x0, x1;
};

Result<std::vector<LoadedStep>> load_steps(Motion& motion, const MemoryTask& task) {
  std::vector<LoadedStep> loaded;
  StepLoader loader(motion);
  for (const StepChoice& step : choose_steps(motion.frame_count(), task.size, task.sampling)) {
    FOLDPROOF_TRY(loader.load(step));
    loaded.push_back({{loader.x0().begin(), loader.x0().end()}, {loader.x1().begin(), loader.x1().end()}});
  }
  return loaded;
}

Result<void> run_foldproof(Motion& motion, const std::vector<LoadedStep>& steps,
                           const HierarchySettings& settings) {
  auto hierarchy = FOLDPROOF_TRY(build_hierarchy(motion, settings));
  StepChecker checker({std::move(hierarchy)});
  StepResult result;
  for (const LoadedStep& step : steps) {
    if (auto done = checker.check(step.x0, step.x1, {}, result); !done) return done;
  }
  return {};
}

Result<void> run_peer(const std::string& name, const Topology& topology,
                      const std::vector<LoadedStep>& steps) {
  for (const PeerEntry& entry : peers()) {
    if (entry.name != name) continue;
    const auto peer = entry.make();
    peer->prepare(topology);
    for (const LoadedStep& step : steps) peer->step(step.x0, step.x1);
    return {};
  }
  return fail("--memory-of", "there is no peer called " + name, "see --list");
}

std::vector<std::string> arguments_for(const MemoryTask& task) {
  std::vector<std::string> arguments = {"foldproof-bench",
                                        "--memory-of",
                                        task.competitor,
                                        "--scene",
                                        task.scene,
                                        "--size",
                                        size_name(task.size),
                                        "--steps",
                                        std::to_string(task.sampling.steps),
                                        "--warm-up",
                                        std::to_string(task.sampling.warm_up),
                                        "--leaf",
                                        std::to_string(task.hierarchy.leaf_triangles),
                                        "--threads",
                                        std::to_string(task.threads)};
  if (task.sampling.all) arguments.push_back("--all-steps");
  return arguments;
}

/// Starts this program again with `arguments` and gives what it prints. A fresh start, not a mere fork: the
/// parent's threads and heap must not be there.
Result<std::string> output_of_self(std::vector<std::string> arguments) {
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  int ends[2];
  if (pipe(ends) != 0) return fail("memory", "no pipe could be opened", "close other programs");
  const pid_t child = fork();
  if (child < 0) return fail("memory", "no process could be started", "close other programs");
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    execv("/proc/self/exe", argv.data());
    _exit(127);
  }
  close(ends[1]);
  std::string output;
  char buffer[256];
  for (ssize_t n = 0; (n = read(ends[0], buffer, sizeof buffer)) > 0;)
    output.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return fail("memory", "the process that measures it failed",
                "run it alone: " + fmt::format("{}", fmt::join(arguments, " ")));
  return output;
}

}  // namespace

Result<double> peak_bytes_in_child(const MemoryTask& task) {
  const auto output = FOLDPROOF_TRY(output_of_self(arguments_for(task)));
  double bytes = 0;
  const auto parsed = std::from_chars(output.data(), output.data() + output.size(), bytes);
  if (parsed.ec != std::errc())
    return fail("memory", "the process that measures it printed no number", "report this");
  return bytes;
}

Result<void> print_peak_bytes(const MemoryTask& task) {
  const SceneInfo* scene = find_scene(task.scene);
  if (scene == nullptr) return fail("--scene", "there is no scene called " + task.scene, "see --list");
  auto motion = FOLDPROOF_TRY(open_scene(*scene));
  const auto steps = FOLDPROOF_TRY(load_steps(*motion, task));
  if (!reset_peak()) return fail("/proc/self/clear_refs", "cannot be written", "run with --no-memory");
  const double before = status_bytes("VmRSS");
  const Topology& topology = (motion)->topology();
  auto done = task.competitor == "foldproof" ? run_foldproof(*motion, steps, task.hierarchy)
                                             : run_peer(task.competitor, topology, steps);
  if (done) fmt::print("{}\n", status_bytes("VmHWM") - before);
  return done;
}

}  // namespace foldproof::bench
