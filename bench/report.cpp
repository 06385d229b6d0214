#include "report.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "checklist.h"
#include "summary.h"
#include "table.h"

namespace foldproof::bench {
namespace {

/// Three significant digits, which is what a clock on a shared machine can tell.
std::string milliseconds(double ms) {
  return fmt::format("{:.{}f}", ms, ms < 1 ? 3 : ms < 10 ? 2 : ms < 100 ? 1 : 0);
}

std::string count(double n) {
  if (n < 10 && n != std::floor(n)) return fmt::format("{:.1f}", n);
  const std::string digits = fmt::format("{:.0f}", n);
  std::string grouped;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) grouped += ',';
    grouped += digits[i];
  }
  return grouped;
}

const char* kind_name(SceneKind kind) {
  constexpr const char* kNames[] = {"motion", "ground truth", "generated", "generated contact", "growth"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::string label(const SceneRecord& record) {
  return record.name +
         (record.kind == SceneKind::Generated || record.kind == SceneKind::Contact ? " (generated)" : "");
}

/// `text` unless the value it was made of is none.
std::string or_dash(double value, const std::string& text) { return std::isnan(value) ? "-" : text; }

std::string ratio(double value) { return or_dash(value, fmt::format("{:.2f}", value)); }

double certificates_of(const SceneRecord& record) { return foldproof_of(record, Way::Certificates); }

bool any_way(const Report& report, Way way) {
  return std::any_of(report.records.begin(), report.records.end(),
                     [way](const SceneRecord& record) { return !std::isnan(foldproof_of(record, way)); });
}

Table main_table(const Report& report) {
  Table table{{"milliseconds a step", "step", "triangles", "warm-up", "steps", "colliding", "floor",
               "foldproof", "x floor", "slowest", "slowest/mean", "searched %"},
              {}};
  const auto embree = families(report.plan);
  const bool trained = any_way(report, Way::Trained), plain = any_way(report, Way::Plain);
  const bool peer = !embree.empty();
  if (trained) table.headers.insert(table.headers.end(), {"trained", "x floor"});
  if (plain) table.headers.push_back("no certificates");
  table.headers.insert(table.headers.end(), {"first", "KB/triangle", "allocations"});
  if (peer) table.headers.insert(table.headers.end(), {embree.front(), embree.front() + "/us"});
  for (const SceneRecord& record : report.records) {
    const double ours = certificates_of(record), floor = floor_of(record);
    std::vector<std::string> row = {label(record),
                                    size_name(record.size),
                                    count(record.triangles),
                                    count(static_cast<double>(record.warm_up.size())),
                                    count(static_cast<double>(record.steps.size())),
                                    count(colliding_steps(record)),
                                    milliseconds(floor),
                                    milliseconds(ours),
                                    fmt::format("{:.1f}", ours / floor),
                                    milliseconds(slowest_of(record)),
                                    fmt::format("{:.1f}", slowest_of(record) / ours),
                                    fmt::format("{:.0f}", 100 * searched_of(record))};
    if (trained) {
      const double ms = foldproof_of(record, Way::Trained);
      row.push_back(or_dash(ms, milliseconds(ms)));
      row.push_back(or_dash(ms, fmt::format("{:.1f}", ms / floor)));
    }
    if (plain) row.push_back(milliseconds(foldproof_of(record, Way::Plain)));
    row.push_back(milliseconds(record.first().of(Way::Certificates).milliseconds));
    const double kilobytes = kilobytes_per_triangle(record, "foldproof");
    row.push_back(or_dash(kilobytes, fmt::format("{:.2f}", kilobytes)));
    row.push_back(count(steady_allocations(record, Way::Certificates)));
    if (peer) {
      const Fastest best = fastest(record, report.plan, embree.front());
      row.push_back(or_dash(best.milliseconds, milliseconds(best.milliseconds)));
      row.push_back(ratio(best.ratio));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::vector<std::string> peer_row(const SceneRecord& record, const Plan& plan) {
  std::vector<std::string> row = {label(record), size_name(record.size)};
  row.push_back(count(mean_of(record, [](const auto& s) { return s.collisions(); })));
  row.push_back(count(mean_of(record, [](const auto& s) {
    const Work& work = s.of(Way::Certificates).work;
    return work.candidates_vf + work.candidates_ee;
  })));
  const std::size_t any = fastest(record, plan, families(plan).front()).peer;
  row.push_back(count(mean_of(record, [any](const auto& s) {
    return s.peers.empty() ? NAN
                           : static_cast<double>(s.peers[any].candidates_vf + s.peers[any].candidates_ee);
  })));
  row.push_back(milliseconds(certificates_of(record)));
  for (const std::string& family : families(plan)) {
    const double ms = fastest(record, plan, family).milliseconds;
    row.push_back(or_dash(ms, milliseconds(ms)));
  }
  for (const std::string& family : families(plan)) row.push_back(ratio(fastest(record, plan, family).ratio));
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
      ratios[c].push_back(fastest(record, report.plan, columns[c]).ratio);
  }
  if (ratios.front().empty()) return;
  std::vector<std::string> row(table.headers.size() - columns.size());
  row[0] = fmt::format("geometric mean of {} {}", ratios.front().size(), name);
  row[1] = size_name(size);
  for (const auto& column : ratios) row.push_back(ratio(geometric_mean(column)));
  table.rows.push_back(std::move(row));
}

Table peer_table(const Report& report) {
  Table table{{"milliseconds a step", "step", "collisions", "candidates", "swept boxes", "foldproof"}, {}};
  for (const std::string& family : families(report.plan)) table.headers.push_back(family);
  for (const std::string& family : families(report.plan)) table.headers.push_back(family + "/us");
  for (const SceneRecord& record : report.records) table.rows.push_back(peer_row(record, report.plan));
  table.rows.push_back({});
  for (const StepSize size : report.plan.sizes) {
    add_mean_row(table, report, "motions", size, [](SceneKind kind) { return kind == SceneKind::Motion; });
    add_mean_row(table, report, "ground truth", size,
                 [](SceneKind kind) { return kind == SceneKind::GroundTruth; });
    add_mean_row(table, report, "generated", size,
                 [](SceneKind kind) { return kind == SceneKind::Generated; });
    add_mean_row(table, report, "generated in contact", size,
                 [](SceneKind kind) { return kind == SceneKind::Contact; });
  }
  return table;
}

Table work_table(const Report& report) {
  Table table{{"foldproof's work a step", "step", "build ms", "train s", "update ms", "traverse ms",
               "narrow ms", "node tests", "certificates", "passed", "leaf pairs", "VF cand.", "EE cand.",
               "VF hits", "EE hits", "undecided"},
              {}};
  for (const SceneRecord& record : report.records) {
    const auto ms = [&](auto member) {
      return milliseconds(
          mean_of(record, [member](const auto& s) { return s.of(Way::Certificates).stages.*member; }));
    };
    const auto work = [&](auto member) {
      return count(mean_of(record, [member](const auto& s) { return s.of(Way::Certificates).work.*member; }));
    };
    table.rows.push_back(
        {label(record), size_name(record.size), milliseconds(record.build_milliseconds),
         record.references == 0 ? "-" : fmt::format("{:.2f}", record.train_seconds), ms(&StageTimes::update),
         ms(&StageTimes::traverse), ms(&StageTimes::narrow), work(&Work::node_tests),
         work(&Work::certificate_tests), work(&Work::certificate_passes), work(&Work::leaf_pairs),
         work(&Work::candidates_vf), work(&Work::candidates_ee),
         count(mean_of(record, [](const auto& s) { return s.collisions_vf; })),
         count(mean_of(record, [](const auto& s) { return s.collisions_ee; })), work(&Work::undecided)});
  }
  return table;
}

Table variants_table(const Report& report) {
  Table table{{"milliseconds a step", "step"}, {}};
  for (const PeerEntry& peer : report.plan.peers) table.headers.push_back(peer.name);
  for (const SceneRecord& record : report.records) {
    std::vector<std::string> row = {label(record), size_name(record.size)};
    for (std::size_t p = 0; p < report.plan.peers.size(); ++p) {
      const double ms = peer_of(record, p);
      row.push_back(or_dash(ms, milliseconds(ms)));
      const double kilobytes = kilobytes_per_triangle(record, report.plan.peers[p].name);
      if (!std::isnan(kilobytes)) row.back() += fmt::format(" ({:.2f} KB)", kilobytes);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string steps_sentence(const Plan& plan) {
  const std::string which = plan.sampling.all ? "all steps" : fmt::format("{} steps", plan.sampling.steps);
  const std::string rounds =
      plan.rounds > 1 ? fmt::format(", each the fastest of {} rounds", plan.rounds) : "";
  const Index warm_up = plan.sampling.warm_up;
  const char* smooth = std::any_of(plan.sizes.begin(), plan.sizes.end(), is_smooth)
                           ? "; \"smooth tenth\": along smooth curves through the frames, and only the "
                             "fastest variant of one peer beside it"
                           : "";
  return fmt::format(
      "Means over {} that follow each other in the middle of each motion (as many as it has; of parts as "
      "many as make whole steps){}, of peers and of foldproof without certificates over {} of them; "
      "foldproof on {} thread{}, peers on one; {} time. "
      "\"warm-up\": before these steps foldproof's new checkers took {} step{}, or as many as the motion has "
      "there, at least one; rows with few include what learning takes. \"first\": the first of them. "
      "\"tenth\": steps cut into ten along the straight lines between frames{}. \"slowest\": foldproof's "
      "slowest step; \"searched %\": steps that made a search of their own, the others were served by an "
      "earlier one. \"allocations\": a median, over the second half of the steps. Foldproof: the "
      "complete answer; peers: candidates only. Ratios are of means.",
      which, rounds, plan.peer_steps, plan.threads, plan.threads == 1 ? "" : "s",
      plan.processor_time ? "processor" : "wall", warm_up, warm_up == 1 ? "" : "s", smooth);
}

constexpr const char* kWayNames[] = {"certificates", "trained", "plain"};

/// To what a clock can tell, which keeps the file of results short.
double rounded(double ms) { return std::round(ms * 1e4) / 1e4; }

nlohmann::json json_of(const StepRecord::OfFoldproof& of) {
  return {{"milliseconds", rounded(of.milliseconds)},
          {"searched", of.searched},
          {"allocations", of.allocations},
          {"stages",
           {{"update", rounded(of.stages.update)},
            {"traverse", rounded(of.stages.traverse)},
            {"narrow", rounded(of.stages.narrow)}}},
          {"work",
           {{"node_tests", of.work.node_tests},
            {"certificate_tests", of.work.certificate_tests},
            {"certificate_passes", of.work.certificate_passes},
            {"leaf_pairs", of.work.leaf_pairs},
            {"candidates_vf", of.work.candidates_vf},
            {"candidates_ee", of.work.candidates_ee},
            {"undecided", of.work.undecided}}}};
}

nlohmann::json json_of(const StepRecord& step, const Plan& plan) {
  nlohmann::json json = {{"frame", step.step.frame},
                         {"part", step.step.part},
                         {"parts", step.step.parts},
                         {"floor_milliseconds", rounded(step.floor_milliseconds)},
                         {"collisions", {{"vf", step.collisions_vf}, {"ee", step.collisions_ee}}}};
  for (std::size_t w = 0; w < kWays.size(); ++w)
    if (!std::isnan(step.ways[w].milliseconds)) json["foldproof"][kWayNames[w]] = json_of(step.ways[w]);
  for (std::size_t p = 0; p < step.peers.size(); ++p) {
    const StepRecord::OfPeer& of = step.peers[p];
    if (std::isnan(of.milliseconds)) continue;
    json["peers"][plan.peers[p].name] = {{"milliseconds", rounded(of.milliseconds)},
                                         {"candidates_vf", of.candidates_vf},
                                         {"candidates_ee", of.candidates_ee}};
  }
  return json;
}

/// Mean milliseconds of everyone who ran.
nlohmann::json means_of(const SceneRecord& record, const Plan& plan) {
  nlohmann::json json = {{"floor", rounded(floor_of(record))}};
  for (const Way way : kWays)
    if (const double ms = foldproof_of(record, way); !std::isnan(ms))
      json["foldproof"][kWayNames[static_cast<std::size_t>(way)]] = rounded(ms);
  for (std::size_t p = 0; p < plan.peers.size(); ++p)
    if (const double ms = peer_of(record, p); !std::isnan(ms))
      json["peers"][plan.peers[p].name] = rounded(ms);
  return json;
}

nlohmann::json json_of(const SceneRecord& record, const Plan& plan) {
  std::vector<double> warm_up;
  for (const StepRecord& step : record.warm_up)
    warm_up.push_back(rounded(step.of(Way::Certificates).milliseconds));
  nlohmann::json scene = {{"name", record.name},
                          {"kind", kind_name(record.kind)},
                          {"step", size_name(record.size)},
                          {"vertices", record.vertices},
                          {"edges", record.edges},
                          {"triangles", record.triangles},
                          {"frames", record.frames},
                          {"build_milliseconds", record.build_milliseconds},
                          {"train_seconds", record.train_seconds},
                          {"references", record.references},
                          {"means", means_of(record, plan)},
                          {"slowest_milliseconds", rounded(slowest_of(record))},
                          {"searched_share", searched_of(record)},
                          {"warm_up_milliseconds", warm_up},
                          {"first", json_of(record.first(), plan)},
                          {"peak_bytes", record.peak_bytes}};
  for (const StepRecord& step : record.steps) scene["steps"].push_back(json_of(step, plan));
  return scene;
}

}  // namespace

std::vector<Goal> all_goals(const Report& report) {
  std::vector<Goal> goals = goals_of(report.records, report.plan);
  for (const char* shape : {"lion", "hand", "cloth"})
    goals.push_back({fmt::format("times as long per triangle at 2,000,000 triangles as at 20,000, {}", shape),
                     1.3, false, growth_of(report.growth, shape)});
  double slowest = report.threads.empty() ? NAN : INFINITY;
  for (const ThreadRecord& r : report.threads) slowest = std::min(slowest, r.one / r.two);
  goals.push_back(
      {"times faster with two threads, 200,000 triangles and more, the least", 1.8, true, slowest});
  double share = NAN;
  for (const TrainingRecord& r : report.training)
    if (r.name == "hand-train") share = r.processor_seconds / report.trained_before;
  goals.push_back({"of the time that training on hand-train took before", 0.5, false, share});
  for (const SceneRecord& record : report.growth)
    goals[kMemoryGoal].reached =
        std::fmax(goals[kMemoryGoal].reached, kilobytes_per_triangle(record, "foldproof"));
  return goals;
}

std::string format_tables(const Report& report, Style style) {
  const auto show = [style](const Table& table) {
    return style == Style::Text ? table.text() : table.markdown();
  };
  std::string out;
  for (const auto& [name, value] : report.machine)
    out += fmt::format("{}{}: {}\n", style == Style::Text ? "" : "* ", name, value);
  out += fmt::format("{}command: {}\n", style == Style::Text ? "" : "* ", report.command);
  const auto add = [&](const Table& table) { out += "\n" + show(table); };
  if (!report.records.empty()) {
    out += "\n" + steps_sentence(report.plan) + "\n";
    add(main_table(report));
    if (!report.plan.peers.empty()) add(peer_table(report));
    add(work_table(report));
    if (!report.plan.peers.empty()) add(variants_table(report));
  }
  if (!report.growth.empty()) add(growth_table(report.growth));
  if (!report.threads.empty()) add(thread_table(report.threads));
  if (!report.training.empty()) add(training_table(report.training));
  add(checklist(all_goals(report)));
  return out;
}

std::string format_json(const Report& report) {
  nlohmann::json json;
  for (const auto& [name, value] : report.machine) json["machine"][name] = value;
  json["command"] = report.command;
  json["processor_time"] = report.plan.processor_time;
  json["threads"] = report.plan.threads;
  json["rounds"] = report.plan.rounds;
  json["warm_up"] = report.plan.sampling.warm_up;
  json["leaf_triangles"] = report.plan.hierarchy.leaf_triangles;
  for (const SceneRecord& record : report.records) json["scenes"].push_back(json_of(record, report.plan));
  Plan alone = report.plan;
  alone.peers.clear();
  for (const SceneRecord& record : report.growth) json["growth"].push_back(json_of(record, alone));
  for (const ThreadRecord& r : report.threads)
    json["thread_scaling"].push_back({{"name", r.name},
                                      {"triangles", r.triangles},
                                      {"steps", r.steps},
                                      {"one_milliseconds", r.one},
                                      {"two_milliseconds", r.two},
                                      {"processors", r.processors}});
  for (const TrainingRecord& r : report.training)
    json["training"].push_back({{"name", r.name},
                                {"triangles", r.triangles},
                                {"poses", r.poses},
                                {"references", r.references},
                                {"wall_seconds", r.wall_seconds},
                                {"processor_seconds", r.processor_seconds},
                                {"proven", r.proven}});
  for (const Goal& goal : all_goals(report))
    json["goals"].push_back({{"what", goal.what},
                             {"target", goal.target},
                             {"at_least", goal.at_least},
                             {"reached", goal.reached}});
  return json.dump() + "\n";  // every step is in it: indented it is three times as long
}

}  // namespace foldproof::bench
