/// foldproof-bench: what a step costs, foldproof's complete answer beside other software's candidates.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "base/parallel.h"
#include "candidates.h"
#include "certificates.h"
#include "machine.h"
#include "memory.h"
#include "reduced.h"
#include "report.h"
#include "simulation.h"

namespace foldproof::bench {
namespace {

struct Options {
  std::vector<std::string> scenes, peers;
  std::string size = "all", json, markdown, memory_of, publish, command;
  bool list = false, quick = false, no_memory = false, certificates = false, candidates = false,
       reduced = false, simulation = false, growth = false, threads = false, training = false;
  int cpu = -1;
  double trained_before = NAN;
  Plan plan;
};

void add_outputs(CLI::App& app, Options& options) {
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_option("--markdown", options.markdown, "Write the tables to this file");
  app.add_option("--publish", options.publish,
                 "Measure all of this, and write results.json and tables.md into this directory");
  app.add_flag("--list", options.list, "Name the scenes and peers, and stop");
  app.add_option("--memory-of", options.memory_of,
                 "Print the peak memory of one competitor on one scene, and stop");
}

void add_options(CLI::App& app, Options& options) {
  Plan& plan = options.plan;
  app.add_option("--scene", options.scenes, "Scenes to run (default: all whose files are there)");
  app.add_option("--size", options.size,
                 "Motions cut along smooth curves through their frames (smooth: into ten, forty and a "
                 "hundred), whole "
                 "steps, steps cut along straight lines, full and tenth (both), or all")
      ->check(CLI::IsMember({"smooth tenth", "smooth fortieth", "smooth hundredth", "full", "tenth",
                             "hundredth", "both", "smooth", "all"}));
  app.add_option(
         "--steps", plan.sampling.steps,
         "Steps per scene at most, from the middle of the motion; of parts as many as make whole steps")
      ->check(CLI::Range(1, 1000000));
  app.add_option("--warm-up", plan.sampling.warm_up,
                 "Steps that checkers take before those measured, as many as the motion has there")
      ->check(CLI::Range(1, 1000000));
  app.add_flag("--all-steps", plan.sampling.all, "Every step of every scene");
  app.add_option("--peer-steps", plan.peer_steps, "Peers run on so many of the steps")
      ->check(CLI::Range(1, 1000000));
  app.add_flag("--quick", options.quick,
               "20 steps, on 4 of them only Embree's fastest variant as peer; no smooth steps, no trained "
               "model, no memory");
  app.add_option("--rounds", plan.rounds, "Run all steps this often; a step's time is its fastest round")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--processor-time", plan.processor_time,
               "Processor time instead of wall time, for a busy machine");
  app.add_option("--peers", options.peers, "Libraries to compare with (default: all; none: foldproof alone)")
      ->delimiter(',');
  app.add_option("--threads", plan.threads, "Threads for foldproof; peers have one")
      ->check(CLI::Range(1, 1024));
  app.add_option("--leaf", plan.hierarchy.leaf_triangles, "Triangles per leaf of foldproof's hierarchy");
  app.add_option("--cpu", options.cpu, "Processor to stay on (default: where it starts)");
  app.add_flag("--verify", plan.verify, "Check that all candidates agree and contain foldproof's answer");
  app.add_flag("--no-memory", options.no_memory, "Do not measure peak memory");
  app.add_flag("--peer-memory", plan.peer_memory, "Measure the peers' peak memory as well");
  app.add_flag("--certificates", options.certificates,
               "Compare foldproof with itself, with certificates and without, after different trainings");
  app.add_flag("--candidates", options.candidates,
               "Candidates within an inflation, of poses that follow each other, for a barrier solver");
  app.add_flag(
      "--reduced", options.reduced,
      "Steps told by coordinates of a subspace: one generated shape at 10,000 to 1,000,000 triangles");
  app.add_flag(
      "--simulation", options.simulation,
      "What an implicit solver asks in the --steps of three simulations: --scene cloth, pile or rod");
  app.add_flag("--growth", options.growth, "The same shapes from 10,000 to 2,000,000 triangles");
  app.add_option("--growth-largest", plan.growth_largest,
                 "Triangles at most, for less memory and time than the largest take (default: no limit)");
  app.add_flag("--thread-scaling", options.threads, "One thread and two, from 200,000 triangles");
  app.add_flag("--training", options.training, "Training on the sets of poses of the data");
  app.add_option(
         "--trained-before", options.trained_before,
         "Processor seconds that training on hand-train took before, on this machine, to compare with")
      ->check(CLI::PositiveNumber);
}

void print_list() {
  for (const auto* scenes : {&all_scenes(), &growth_scenes()})
    for (const SceneInfo& scene : *scenes)
      fmt::print("scene {}{}\n", scene.name, is_available(scene) ? "" : " (its files are missing)");
  for (const PeerEntry& peer : peers()) fmt::print("peer {} ({} {})\n", peer.name, peer.family, peer.version);
}

Result<std::vector<PeerEntry>> chosen_peers(const std::vector<std::string>& names) {
  std::vector<PeerEntry> all = peers(), chosen;
  if (names.empty()) return all;
  if (names == std::vector<std::string>{"none"}) return chosen;
  for (const std::string& name : names) {
    const auto count = chosen.size();
    std::copy_if(all.begin(), all.end(), std::back_inserter(chosen),
                 [&](const PeerEntry& peer) { return peer.family == name || peer.name == name; });
    if (chosen.size() == count) return fail("--peers", "there is no peer called " + name, "see --list");
  }
  return chosen;
}

Result<std::vector<SceneInfo>> chosen_scenes(const std::vector<std::string>& names) {
  std::vector<SceneInfo> chosen;
  for (const std::string& name : names) {
    const SceneInfo* scene = find_scene(name);
    if (scene == nullptr) return fail("--scene", "there is no scene called " + name, "see --list");
    chosen.push_back(*scene);
  }
  if (!names.empty()) return chosen;
  std::vector<std::string> missing;
  for (const SceneInfo& scene : all_scenes())
    if (is_available(scene))
      chosen.push_back(scene);
    else
      missing.push_back(scene.name);
  if (!missing.empty())
    fmt::print(stderr, "Left out, for their files are not in {} (set FOLDPROOF_DATA): {}\n",
               data_directory().string(), fmt::join(missing, ", "));
  return chosen;
}

Result<void> write_text(const std::string& path, const std::string& text) {
  auto file = FileWriter::open(path);
  if (!file) return tl::unexpected(file.error());
  if (auto written = file->write(text); !written) return written;
  return file->commit();
}

Result<void> run_all(const Options& options, Report& report) {
  const auto scenes = chosen_scenes(options.scenes);
  if (!scenes) return tl::unexpected(scenes.error());
  const bool narrate = isatty(STDERR_FILENO) != 0;
  for (const SceneInfo& scene : *scenes) {
    if (narrate) fmt::print(stderr, "\r\033[K{} ...", scene.name);
    auto records = measure(scene, report.plan);
    if (!records) return tl::unexpected(records.error());
    std::move(records->begin(), records->end(), std::back_inserter(report.records));
  }
  if (narrate) fmt::print(stderr, "\r\033[K");
  return {};
}

Result<void> run_certificates(const Options& options) {
  const auto scenes = chosen_scenes(options.scenes);
  if (!scenes) return tl::unexpected(scenes.error());
  CertificatePlan plan;
  plan.processor_time = options.plan.processor_time;
  const auto table = compare_certificates(*scenes, plan);
  if (!table) return tl::unexpected(table.error());
  fmt::print("{}", table->text());
  return options.markdown.empty() ? Result<void>{} : write_text(options.markdown, table->markdown());
}

Result<void> run_candidates(const Options& options, const std::vector<PeerEntry>& peers) {
  const auto scenes = chosen_scenes(options.scenes);
  if (!scenes) return tl::unexpected(scenes.error());
  const auto table =
      measure_candidates(*scenes, {.peers = peers, .processor_time = options.plan.processor_time});
  if (!table) return tl::unexpected(table.error());
  fmt::print("{}", table->text());
  return options.markdown.empty() ? Result<void>{} : write_text(options.markdown, table->markdown());
}

Result<void> run_simulation(const Options& options, const std::vector<PeerEntry>& peers) {
  const auto table = measure_simulation({.peers = peers,
                                         .steps = options.plan.sampling.steps,
                                         .only = options.scenes.empty() ? "" : options.scenes.front(),
                                         .processor_time = options.plan.processor_time,
                                         .narrate = isatty(STDERR_FILENO) != 0});
  if (!table) return tl::unexpected(table.error());
  fmt::print("{}", table->text());
  return options.markdown.empty() ? Result<void>{} : write_text(options.markdown, table->markdown());
}

Result<void> run_reduced(const Options& options) {
  ReducedPlan plan;
  plan.processor_time = options.plan.processor_time;
  const auto table = measure_reduced(plan);
  if (!table) return tl::unexpected(table.error());
  fmt::print("{}", table->text());
  return options.markdown.empty() ? Result<void>{} : write_text(options.markdown, table->markdown());
}

/// The main tables, unless something else was asked for.
Result<void> run_chosen(const Options& options, Report& report) {
  const bool everything = !options.publish.empty();
  if (everything || !(options.growth || options.threads || options.training))
    if (auto done = run_all(options, report); !done) return done;
  if (everything || options.growth) {
    auto growth = measure_growth(report.plan);
    if (!growth) return tl::unexpected(growth.error());
    report.growth = std::move(*growth);
  }
  if (everything || options.training) {
    auto training = measure_training();
    if (!training) return tl::unexpected(training.error());
    report.training = std::move(*training);
  }
  return {};
}

Result<void> write_files(const Options& options, const Report& report) {
  std::string json = options.json, markdown = options.markdown;
  if (!options.publish.empty()) {
    json = options.publish + "/results.json";
    markdown = options.publish + "/tables.md";
  }
  if (!json.empty())
    if (auto written = write_text(json, format_json(report)); !written) return written;
  return markdown.empty() ? Result<void>{} : write_text(markdown, format_tables(report, Style::Markdown));
}

std::vector<StepSize> sizes_called(const std::string& name) {
  if (name == "both") return {StepSize::Full, StepSize::Tenth};
  std::vector<StepSize> sizes;
  for (const StepSize size : kStepSizes)
    if (name == "all" || (name == "smooth" && is_smooth(size)) || name == size_name(size))
      sizes.push_back(size);
  return sizes;
}

void make_quick(Options& options) {
  Plan& plan = options.plan;
  plan.sampling.steps = std::min<Index>(plan.sampling.steps, 20);
  plan.peer_steps = std::min<Index>(plan.peer_steps, 4);
  plan.one_variant = true;
  plan.trained = plan.memory = false;
  if (options.size == "all") std::erase_if(plan.sizes, is_smooth);
  if (options.peers.empty()) options.peers = {"Embree"};
}

Result<void> run(Options& options) {
  if (options.list) {
    print_list();
    return {};
  }
  Plan& plan = options.plan;
  plan.memory = !options.no_memory;
  plan.sizes = sizes_called(options.size);
  if (options.quick) make_quick(options);
  Report report;
  const bool can_have_two = std::thread::hardware_concurrency() > 1;
  if (options.threads || (!options.publish.empty() && can_have_two)) {
    auto threads = measure_threads(plan);
    if (!threads) return tl::unexpected(threads.error());
    report.threads = std::move(*threads);
  }
  // From here on one processor and one thread, which those that oneTBB has by now would not know of.
  if (plan.threads == 1 && !pin_to_one_cpu(options.cpu))
    return fail("--cpu", "the system does not let this program stay there", "name another processor");
  const ThreadLimit limit(plan.threads);
  if (!options.memory_of.empty()) {
    if (options.scenes.size() != 1) return fail("--memory-of", "needs one scene", "add --scene NAME");
    return print_peak_bytes({options.scenes.front(), options.memory_of, plan.sizes.front(), plan.sampling,
                             plan.hierarchy, plan.threads});
  }
  if (options.certificates) return run_certificates(options);
  if (options.reduced) return run_reduced(options);
  auto peers = chosen_peers(options.peers);
  if (!peers) return tl::unexpected(peers.error());
  if (options.candidates) return run_candidates(options, *peers);
  if (options.simulation) return run_simulation(options, *peers);
  plan.peers = std::move(*peers);
  report.machine = machine_facts(plan.peers);
  report.plan = plan;
  report.command = options.command;
  report.trained_before = options.trained_before;
  if (auto done = run_chosen(options, report); !done) return done;
  fmt::print("{}", format_tables(report, Style::Text));
  return write_files(options, report);
}

}  // namespace
}  // namespace foldproof::bench

int main(int argc, char** argv) {
  CLI::App app(
      "Times foldproof's complete answer beside other software's candidates, on the same steps in the same "
      "run.");
  foldproof::bench::Options options;
  foldproof::bench::add_options(app, options);
  foldproof::bench::add_outputs(app, options);
  options.command = fmt::format("foldproof-bench {}", fmt::join(argv + 1, argv + argc, " "));
  CLI11_PARSE(app, argc, argv);
  if (const auto done = foldproof::bench::run(options); !done) {
    fmt::print(stderr, "foldproof-bench: {}\n", done.error().line());
    return 2;
  }
  return 0;
}
