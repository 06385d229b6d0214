/// foldproof-bench: what a step costs, foldproof's complete answer beside other software's candidates. Writes
/// JSON, of which tools/bench_tables makes tables.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "base/parallel.h"
#include "base/try.h"
#include "candidates.h"
#include "certificates.h"
#include "contacts.h"
#include "families.h"
#include "machine.h"
#include "memory.h"
#include "reduced.h"
#include "report.h"
#include "scaling.h"
#include "simulation.h"
#include "solver.h"
#include "span.h"

namespace foldproof::bench {
namespace {

using nlohmann::json;

struct Options {
  std::vector<std::string> scenes, peers;
  std::string size = "all", json = "-", memory_of, command;
  bool list = false, quick = false, no_memory = false, certificates = false, candidates = false,
       contacts = false, reduced = false, simulation = false, solver = false, growth = false, threads = false,
       training = false, span = false, everything = false;
  int cpu = -1;
  Plan plan;
};

void add_outputs(CLI::App& app, Options& options) {
  app.add_option("--json", options.json, "Write all figures to this file (default: -, standard output)");
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
  app.add_option("--cpu", options.cpu, "Processor to stay on, with one thread (default: where it starts)");
  app.add_flag("--verify", plan.verify, "Check that all candidates agree and contain foldproof's answer");
  app.add_flag("--no-memory", options.no_memory, "Do not measure peak memory");
  app.add_flag("--peer-memory", plan.peer_memory, "Measure the peers' peak memory as well");
}

/// Other tables than the main ones.
void add_tables(CLI::App& app, Options& options) {
  app.add_flag("--certificates", options.certificates,
               "Compare foldproof with itself, with certificates and without, after different trainings");
  app.add_flag("--candidates", options.candidates,
               "Candidates within an inflation, of poses that follow each other, for a barrier solver");
  app.add_flag("--contacts", options.contacts,
               "What finding contacts costs beside the check, on whole motions");
  app.add_flag(
      "--reduced", options.reduced,
      "Steps told by coordinates of a subspace: one generated shape at 10,000 to 1,000,000 triangles");
  app.add_flag(
      "--simulation", options.simulation,
      "What an implicit solver asks in the --steps of three simulations: --scene cloth, pile or rod");
  app.add_flag("--solver", options.solver,
               "What it asks of two sheets: long steps, bounds, pairs within a distance; and --simulation");
  app.add_flag("--growth", options.growth,
               "The same shapes from 10,000 to 2,000,000 triangles, and families of many at one place");
  app.add_option("--growth-largest", options.plan.growth_largest,
                 "Triangles at most, for less memory and time than the largest take (default: no limit)");
  app.add_flag("--thread-scaling", options.threads, "1, 2, 4, ... threads, from 200,000 triangles");
  app.add_flag(
      "--span", options.span,
      "How many times sooner 2 and 16 processors would end a step, from its loops on one (preset span)");
  app.add_flag("--training", options.training, "Training on the sets of poses of the data");
  app.add_flag("--everything", options.everything,
               "The main tables, --growth, --thread-scaling and --training");
  // Each of these is measured alone.
  const std::vector<std::string> alone = {"--certificates", "--candidates", "--contacts", "--reduced",
                                          "--simulation",   "--solver",     "--span"};
  for (const std::string& name : alone) {
    for (const std::string& other : alone)
      if (name != other) app.get_option(name)->excludes(app.get_option(other));
    for (const char* other : {"--growth", "--thread-scaling", "--training", "--everything"})
      app.get_option(name)->excludes(app.get_option(other));
  }
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

Result<json> measure_main(const Options& options) {
  const auto scenes = FOLDPROOF_TRY(chosen_scenes(options.scenes));
  return measure_scenes(scenes, options.plan);
}

/// The main rows, unless something else was asked for.
Result<void> measure_chosen(const Options& options, json& results) {
  const Plan& plan = options.plan;
  const auto keep = [&](const char* name, Result<json> rows) {
    return std::move(rows).map([&](json&& measured) { results[name] = std::move(measured); });
  };
  const bool time = plan.processor_time;
  if (options.reduced) return keep("reduced", measure_reduced({.processor_time = time}));
  if (options.solver) FOLDPROOF_TRY(keep("solver", measure_solver({.processor_time = time})));
  if (options.simulation || options.solver)
    return keep("simulation",
                measure_simulation({.peers = plan.peers,
                                    .steps = plan.sampling.steps,
                                    .only = options.scenes.empty() ? "" : options.scenes.front(),
                                    .processor_time = time,
                                    .narrate = isatty(STDERR_FILENO) != 0}));
  if (options.certificates || options.candidates || options.contacts) {
    const auto scenes = FOLDPROOF_TRY(chosen_scenes(options.scenes));
    if (options.contacts) return keep("contacts", measure_contacts(scenes, time));
    if (options.certificates)
      return keep("certificates", compare_certificates(scenes, {.processor_time = time}));
    return keep("candidates", measure_candidates(scenes, {.peers = plan.peers, .processor_time = time}));
  }
  if (options.span) {
    std::vector<SceneInfo> scenes = FOLDPROOF_TRY(chosen_scenes(options.scenes));
    if (options.scenes.empty()) scenes.insert(scenes.end(), growth_scenes().begin(), growth_scenes().end());
    return keep("span", measure_span(scenes, plan));
  }
  if (options.everything || !(options.growth || options.threads || options.training))
    FOLDPROOF_TRY(keep("scenes", measure_main(options)));
  if (options.everything || options.growth) {
    FOLDPROOF_TRY(keep("growth", measure_growth(plan)));
    FOLDPROOF_TRY(keep("families", measure_families(time)));
  }
  if (options.everything || options.training) FOLDPROOF_TRY(keep("training", measure_training()));
  return {};
}

/// What was asked for, and on what it ran.
void add_facts(const Options& options, json& results) {
  const Plan& plan = options.plan;
  results["machine"] = machine_facts(plan.peers);
  results["command"] = options.command;
  results["processor_time"] = plan.processor_time;
  results["threads"] = plan.threads;
  results["rounds"] = plan.rounds;
  results["steps"] = plan.sampling.steps;
  results["all_steps"] = plan.sampling.all;
  results["warm_up"] = plan.sampling.warm_up;
  results["peer_steps"] = plan.peer_steps;
  results["leaf_triangles"] = plan.hierarchy.leaf_triangles;
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
  if ((options.simulation || options.solver) && options.scenes.size() > 1)
    return fail("--scene", "a simulation is of one scene, or all",
                "name one of cloth, pile and rod, or none");
  Plan& plan = options.plan;
  plan.memory = !options.no_memory;
  plan.sizes = sizes_called(options.size);
  if (options.quick) make_quick(options);
  auto peers = FOLDPROOF_TRY(chosen_peers(options.peers));
  plan.peers = std::move(peers);
  if (plan.verify && plan.peers.size() < 2)
    return fail("--verify", fmt::format("compares peers, of which there are {}", plan.peers.size()),
                "name two of --list, or install their libraries");
  // Opened before anything is measured: whoever names no place for the results learns it now.
  auto file = FOLDPROOF_TRY(FileWriter::open(options.json));
  json results;
  const bool can_have_two = std::thread::hardware_concurrency() > 1;
  if (options.threads || (options.everything && can_have_two)) {
    auto threads = FOLDPROOF_TRY(measure_threads(plan));
    results["thread_scaling"] = std::move(threads);
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
  FOLDPROOF_TRY(measure_chosen(options, results));
  add_facts(options, results);
  FOLDPROOF_TRY(file.write(results.dump() + "\n"));
  return file.commit();
}

}  // namespace
}  // namespace foldproof::bench

int main(int argc, char** argv) {
  CLI::App app(
      "Times foldproof's complete answer beside other software's candidates, on the same steps in the same "
      "run.");
  foldproof::bench::Options options;
  foldproof::bench::add_options(app, options);
  foldproof::bench::add_tables(app, options);
  foldproof::bench::add_outputs(app, options);
  options.command = fmt::format("foldproof-bench {}", fmt::join(argv + 1, argv + argc, " "));
  CLI11_PARSE(app, argc, argv);
  if (const auto done = foldproof::bench::run(options); !done) {
    fmt::print(stderr, "foldproof-bench: {}\n", done.error().line());
    return 2;
  }
  return 0;
}
