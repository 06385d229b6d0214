#include "report.h"

#include <unistd.h>

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/try.h"

namespace foldproof::bench {
namespace {

using nlohmann::json;

constexpr const char* kWayNames[] = {"certificates", "trained", "plain"};

json json_of(const StepRecord::OfFoldproof& of) {
  return {{"milliseconds", of.milliseconds},
          {"searched", of.searched},
          {"allocations", of.allocations},
          {"stages",
           {{"update", of.stages.update}, {"traverse", of.stages.traverse}, {"narrow", of.stages.narrow}}},
          {"work",
           {{"refits", of.work.refits},
            {"node_tests", of.work.node_tests},
            {"certificate_tests", of.work.certificate_tests},
            {"certificate_passes", of.work.certificate_passes},
            {"leaf_pairs", of.work.leaf_pairs},
            {"candidates_vf", of.work.candidates_vf},
            {"candidates_ee", of.work.candidates_ee},
            {"undecided", of.work.undecided}}}};
}

json json_of(const StepRecord& step, const Plan& plan) {
  json out = {{"frame", step.step.frame},
              {"part", step.step.part},
              {"parts", step.step.parts},
              {"floor_milliseconds", step.floor_milliseconds},
              {"collisions", {{"vf", step.collisions_vf}, {"ee", step.collisions_ee}}}};
  for (std::size_t w = 0; w < kWays.size(); ++w)
    if (!std::isnan(step.ways[w].milliseconds)) out["foldproof"][kWayNames[w]] = json_of(step.ways[w]);
  for (std::size_t p = 0; p < step.peers.size(); ++p) {
    const StepRecord::OfPeer& of = step.peers[p];
    if (std::isnan(of.milliseconds)) continue;
    out["peers"][plan.peers[p].name] = {{"milliseconds", of.milliseconds},
                                        {"candidates_vf", of.candidates_vf},
                                        {"candidates_ee", of.candidates_ee}};
  }
  return out;
}

json json_of(const SceneRecord& record, const Plan& plan) {
  json scene = {{"name", record.name},
                {"kind", kind_name(record.kind)},
                {"step", size_name(record.size)},
                {"vertices", record.vertices},
                {"edges", record.edges},
                {"triangles", record.triangles},
                {"frames", record.frames},
                {"build_milliseconds", record.build_milliseconds},
                {"train_seconds", record.train_seconds},
                {"references", record.references},
                {"first", json_of(record.warm_up.front(), plan)},
                {"peak_bytes", record.peak_bytes}};
  for (const StepRecord& step : record.warm_up)
    scene["warm_up_milliseconds"].push_back(step.of(Way::Certificates).milliseconds);
  for (const StepRecord& step : record.steps) scene["steps"].push_back(json_of(step, plan));
  return scene;
}

void print_line(const SceneRecord& record) {
  double ours = 0, floor = 0;
  for (const StepRecord& step : record.steps) {
    ours += step.of(Way::Certificates).milliseconds;
    floor += step.floor_milliseconds;
  }
  fmt::print(stderr, "{:<17}{:<17}{:9.3f} ms a step, {:7.1f} times the floor\n", record.name,
             size_name(record.size), ours / static_cast<double>(record.steps.size()), ours / floor);
}

}  // namespace

Result<json> measure_scenes(const std::vector<SceneInfo>& scenes, const Plan& plan) {
  const bool narrate = isatty(STDERR_FILENO) != 0;
  json out = json::array();
  for (const SceneInfo& scene : scenes) {
    if (narrate) fmt::print(stderr, "{} ...", scene.name);
    const auto records = FOLDPROOF_TRY(measure(scene, plan));
    if (narrate) fmt::print(stderr, "\r\033[K");
    for (const SceneRecord& record : records) {
      print_line(record);
      out.push_back(json_of(record, plan));
    }
  }
  return out;
}

}  // namespace foldproof::bench
