#include "report.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "table.h"

namespace foldproof::bench {
namespace {

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

/// Median over the steps of a record of whatever `value` reads from a step.
template <class Value>
double median_of(const SceneRecord& record, Value value) {
  std::vector<double> values;
  for (const StepRecord& step : record.steps) values.push_back(static_cast<double>(value(step)));
  return median(std::move(values));
}

double geometric_mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += std::log(v);
  return std::exp(sum / static_cast<double>(values.size()));
}

/// Three significant digits, which is what a clock on a shared machine can tell.
std::string milliseconds(double ms) { return fmt::format("{:.{}f}", ms, ms < 10 ? 2 : ms < 100 ? 1 : 0); }

std::string count(double n) {
  const std::string digits = fmt::format("{:.0f}", n);
  std::string grouped;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) grouped += ',';
    grouped += digits[i];
  }
  return grouped;
}

const char* size_name(StepSize size) { return size == StepSize::Full ? "full" : "tenth"; }

const char* kind_name(SceneKind kind) {
  return kind == SceneKind::Motion ? "motion" : kind == SceneKind::GroundTruth ? "ground truth" : "generated";
}

std::string label(const SceneRecord& record) {
  return record.name + (record.kind == SceneKind::Generated ? " (generated)" : "");
}

std::vector<std::string> families(const Plan& plan) {
  std::vector<std::string> names;
  for (const PeerEntry& peer : plan.peers)
    if (std::find(names.begin(), names.end(), peer.family) == names.end()) names.push_back(peer.family);
  // Embree first: it is the one that the goals are stated against.
  std::stable_partition(names.begin(), names.end(), [](const std::string& name) { return name == "Embree"; });
  return names;
}

/// A family's fastest variant on this record.
struct Fastest {
  std::size_t peer = 0;
  double milliseconds = INFINITY;
};
Fastest fastest(const SceneRecord& record, const Plan& plan, const std::string& family) {
  Fastest best;
  for (std::size_t p = 0; p < plan.peers.size(); ++p) {
    if (plan.peers[p].family != family) continue;
    const double ms = median_of(record, [p](const StepRecord& step) { return step.peers[p].milliseconds; });
    if (ms < best.milliseconds) best = {p, ms};
  }
  return best;
}

double foldproof_milliseconds(const SceneRecord& record) {
  return median_of(record, [](const StepRecord& step) { return step.milliseconds; });
}

double kilobytes_per_triangle(const SceneRecord& record, const std::string& competitor) {
  const auto peak = record.peak_bytes.find(competitor);
  return peak == record.peak_bytes.end() ? NAN : peak->second / 1000 / record.triangles;
}

std::string or_dash(double value, const char* format) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

std::vector<std::string> main_row(const SceneRecord& record, const Plan& plan) {
  std::vector<std::string> row = {label(record), size_name(record.size), count(record.triangles)};
  row.push_back(count(median_of(record, [](const auto& s) { return s.collisions_vf + s.collisions_ee; })));
  row.push_back(
      count(median_of(record, [](const auto& s) { return s.work.candidates_vf + s.work.candidates_ee; })));
  if (!plan.peers.empty())
    row.push_back(count(median_of(
        record, [](const auto& s) { return s.peers[0].candidates_vf + s.peers[0].candidates_ee; })));
  row.push_back(or_dash(kilobytes_per_triangle(record, "foldproof"), "{:.2f}"));
  const double ours = foldproof_milliseconds(record);
  row.push_back(milliseconds(ours));
  for (const std::string& family : families(plan))
    row.push_back(milliseconds(fastest(record, plan, family).milliseconds));
  for (const std::string& family : families(plan))
    row.push_back(fmt::format("{:.2f}", fastest(record, plan, family).milliseconds / ours));
  return row;
}

/// Geometric means of the ratios over the records that `wanted` picks.
template <class Wanted>
void add_mean_row(Table& table, const Report& report, const std::string& name, StepSize size, Wanted wanted) {
  const auto columns = families(report.plan);
  std::vector<std::vector<double>> ratios(columns.size());
  for (const SceneRecord& record : report.records) {
    if (record.size != size || !wanted(record.kind)) continue;
    for (std::size_t c = 0; c < columns.size(); ++c)
      ratios[c].push_back(fastest(record, report.plan, columns[c]).milliseconds /
                          foldproof_milliseconds(record));
  }
  if (ratios.empty() || ratios.front().empty()) return;
  std::vector<std::string> row(table.headers.size() - columns.size());
  row[0] = fmt::format("geometric mean of {} {}", ratios.front().size(), name);
  row[1] = size_name(size);
  for (const auto& column : ratios) row.push_back(fmt::format("{:.2f}", geometric_mean(column)));
  table.rows.push_back(std::move(row));
}

Table main_table(const Report& report) {
  Table table{{"milliseconds a step", "step", "triangles", "collisions", "candidates"}, {}};
  if (!report.plan.peers.empty()) table.headers.push_back("swept boxes");
  table.headers.insert(table.headers.end(), {"KB/triangle", "foldproof"});
  for (const std::string& family : families(report.plan)) table.headers.push_back(family);
  for (const std::string& family : families(report.plan)) table.headers.push_back(family + "/us");
  for (const SceneRecord& record : report.records) table.rows.push_back(main_row(record, report.plan));
  table.rows.push_back({});
  const bool has_truth =
      std::any_of(report.records.begin(), report.records.end(),
                  [](const SceneRecord& record) { return record.kind == SceneKind::GroundTruth; });
  for (const StepSize size : report.plan.sizes) {
    add_mean_row(table, report, "motions", size, [](SceneKind kind) { return kind == SceneKind::Motion; });
    if (has_truth)
      add_mean_row(table, report, "with ground truth", size,
                   [](SceneKind kind) { return kind != SceneKind::Generated; });
    add_mean_row(table, report, "generated", size,
                 [](SceneKind kind) { return kind == SceneKind::Generated; });
  }
  return table;
}

Table work_table(const Report& report) {
  Table table{
      {"foldproof's work a step", "step", "build ms", "update ms", "traverse ms", "narrow ms", "node tests",
       "certificates", "passed", "leaf pairs", "VF cand.", "EE cand.", "VF hits", "EE hits", "undecided"},
      {}};
  for (const SceneRecord& record : report.records) {
    const auto ms = [&](auto member) {
      return milliseconds(median_of(record, [member](const auto& s) { return s.stages.*member; }));
    };
    const auto work = [&](auto member) {
      return count(median_of(record, [member](const auto& s) { return s.work.*member; }));
    };
    table.rows.push_back(
        {label(record), size_name(record.size), milliseconds(record.build_milliseconds),
         ms(&StageTimes::update), ms(&StageTimes::traverse), ms(&StageTimes::narrow), work(&Work::node_tests),
         work(&Work::certificate_tests), work(&Work::certificate_passes), work(&Work::leaf_pairs),
         work(&Work::candidates_vf), work(&Work::candidates_ee),
         count(median_of(record, [](const auto& s) { return s.collisions_vf; })),
         count(median_of(record, [](const auto& s) { return s.collisions_ee; })), work(&Work::undecided)});
  }
  return table;
}

Table variants_table(const Report& report) {
  Table table{{"milliseconds a step", "step"}, {}};
  for (const PeerEntry& peer : report.plan.peers) table.headers.push_back(peer.name);
  for (const SceneRecord& record : report.records) {
    std::vector<std::string> row = {label(record), size_name(record.size)};
    for (std::size_t p = 0; p < report.plan.peers.size(); ++p) {
      row.push_back(milliseconds(median_of(record, [p](const auto& s) { return s.peers[p].milliseconds; })));
      const double kilobytes = kilobytes_per_triangle(record, report.plan.peers[p].name);
      if (!std::isnan(kilobytes)) row.back() += fmt::format(" ({:.2f} KB)", kilobytes);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string steps_sentence(const Plan& plan) {
  const std::string which = plan.sampling.all ? "all steps"
                            : plan.sampling.consecutive
                                ? fmt::format("{} consecutive steps", plan.sampling.steps)
                                : fmt::format("{} evenly spread steps", plan.sampling.steps);
  const std::string rounds =
      plan.rounds > 1 ? fmt::format(", each the fastest of {} rounds", plan.rounds) : "";
  return fmt::format(
      "Medians over {} of each motion (as many as it has){}; foldproof on {} thread{}, peers on one; {} "
      "time. "
      "\"tenth\" is a tenth of a step. Foldproof: the complete answer; peers: candidates only.",
      which, rounds, plan.threads, plan.threads == 1 ? "" : "s", plan.processor_time ? "processor" : "wall");
}

nlohmann::json json_of(const StepRecord& step, const Plan& plan) {
  nlohmann::json json = {{"frame", step.step.frame},
                         {"tenth", step.step.tenth},
                         {"foldproof",
                          {{"milliseconds", step.milliseconds},
                           {"stages",
                            {{"total", step.stages.total},
                             {"update", step.stages.update},
                             {"traverse", step.stages.traverse},
                             {"narrow", step.stages.narrow}}},
                           {"work",
                            {{"node_tests", step.work.node_tests},
                             {"certificate_tests", step.work.certificate_tests},
                             {"certificate_passes", step.work.certificate_passes},
                             {"leaf_pairs", step.work.leaf_pairs},
                             {"candidates_vf", step.work.candidates_vf},
                             {"candidates_ee", step.work.candidates_ee},
                             {"undecided", step.work.undecided}}},
                           {"collisions", {{"vf", step.collisions_vf}, {"ee", step.collisions_ee}}}}}};
  for (std::size_t p = 0; p < step.peers.size(); ++p)
    json[plan.peers[p].name] = {{"milliseconds", step.peers[p].milliseconds},
                                {"candidates_vf", step.peers[p].candidates_vf},
                                {"candidates_ee", step.peers[p].candidates_ee}};
  return json;
}

}  // namespace

std::string format_tables(const Report& report, Style style) {
  const auto show = [style](const Table& table) {
    return style == Style::Text ? table.text() : table.markdown();
  };
  std::string out;
  for (const auto& [name, value] : report.machine)
    out += fmt::format("{}{}: {}\n", style == Style::Text ? "" : "* ", name, value);
  out += fmt::format("{}command: {}\n\n{}\n\n", style == Style::Text ? "" : "* ", report.command,
                     steps_sentence(report.plan));
  out += show(main_table(report)) + "\n" + show(work_table(report));
  if (!report.plan.peers.empty()) out += "\n" + show(variants_table(report));
  return out;
}

std::string format_json(const Report& report) {
  nlohmann::json json;
  for (const auto& [name, value] : report.machine) json["machine"][name] = value;
  json["command"] = report.command;
  json["processor_time"] = report.plan.processor_time;
  json["threads"] = report.plan.threads;
  json["rounds"] = report.plan.rounds;
  json["leaf_triangles"] = report.plan.hierarchy.leaf_triangles;
  for (const SceneRecord& record : report.records) {
    nlohmann::json scene = {{"name", record.name},
                            {"kind", kind_name(record.kind)},
                            {"step", size_name(record.size)},
                            {"vertices", record.vertices},
                            {"edges", record.edges},
                            {"triangles", record.triangles},
                            {"frames", record.frames},
                            {"build_milliseconds", record.build_milliseconds},
                            {"peak_bytes", record.peak_bytes}};
    for (const StepRecord& step : record.steps) scene["steps"].push_back(json_of(step, report.plan));
    json["scenes"].push_back(std::move(scene));
  }
  return json.dump(1) + "\n";
}

}  // namespace foldproof::bench
