#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/try.h"
#include "commands.h"
#include "file_arguments.h"
#include "foldproof/model.h"
#include "io/bytes.h"
#include "learned_text.h"
#include "terminal.h"

namespace foldproof {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kInfoFooter =
    R"(It shows the poses that the model was trained on, its size, and how much of the mesh it proves free of contact with
itself:

  proven    share of leaves (patches of about a dozen triangles) and of pairs of neighboring leaves that the charts
            prove in a pose. What is not proven is tested; no answer depends on it.
  kappa     steepness of charts: how many times longer a path on the surface may be than the straight line below it in
            the chart. 1 is flat. The steeper a chart, the less the patch may bend before the chart stops holding.
  hard      leaves that neither their own charts nor those of a level above prove in a reference pose, and why.

Of what was learned about the mesh's shapes it shows reconstruction errors, as distances of vertices, and the accuracy
of predicted certificates:

  projection     between a training pose and its reconstruction in the subspace
  cueing         what reconstruction from key points alone adds to that
  leave-one-out  between a training pose and its reconstruction from what the other poses teach (with kernel PCA too,
                 in a linear subspace)
  balanced accuracy
                 of predictions for held-out poses, over nodes that are proven in some poses but not in others. 50 % is
                 chance; 'majority' is the accuracy of always predicting a node's more frequent outcome. Charts of
                 these poses and thresholds are kept, so both are better than in new poses.

Examples:
  foldproof info body.model
  foldproof info body.model --json body.json)";

struct InfoArguments {
  std::string model, json;
  FileArguments files;
};

/// How many of the hardest leaves are listed.
constexpr std::size_t kListedLeaves = 8;

const char* reason(Obstacle obstacle) {
  switch (obstacle) {
    case Obstacle::TooCurved:
      return "too curved";
    case Obstacle::Overlapping:
      return "overlapping";
    case Obstacle::TooThin:
      return "too thin";
  }
  return "";
}

/// Those that are hard in most references first.
std::vector<HardLeaf> sorted_hard_leaves(const Model& model) {
  std::vector<HardLeaf> leaves = model.hard_leaves;
  std::stable_sort(leaves.begin(), leaves.end(),
                   [](const HardLeaf& a, const HardLeaf& b) { return a.references > b.references; });
  return leaves;
}

std::span<const Index> triangles_of(const Model& model, const HardLeaf& hard) {
  const Hierarchy& h = *model.hierarchy();
  const Index begin = h.leaves()[hard.leaf].triangles, end = h.leaves()[hard.leaf + 1].triangles;
  return h.triangle_ids().subspan(begin, end - begin);
}

/// To two digits, rounded up: a bound stays a bound.
double rounded_up(double kappa) { return std::ceil(kappa * 100) / 100; }

std::string overview(const Model& model, const ModelSummary& s, std::uint64_t bytes) {
  const Topology& mesh = model.hierarchy()->topology();
  std::string text;
  const auto row = [&](const char* label, const std::string& value) {
    text += fmt::format("{:<24}{}\n", label, value);
  };
  row("model", cell(model.name));
  row("trained by", "foldproof " + cell(model.program));
  row("mesh", fmt::format("{} triangles, {} vertices, hash {:016x}", grouped(mesh.triangles().size()),
                          grouped(mesh.vertex_count()), topology_hash(mesh)));
  row("size",
      fmt::format("{:.3g} MB  ({:.3g} bytes per triangle and reference)", static_cast<double>(bytes) / 1e6,
                  static_cast<double>(bytes) / static_cast<double>(mesh.triangles().size()) /
                      std::max<Index>(s.references, 1)));
  row("charts", grouped(model.chart_count()));
  row("poses", fmt::format("{}  ({})", grouped(model.poses.size()), counted(s.references, "reference")));
  row("proven", fmt::format("{:.1f} %", 100 * s.proven));
  if (model.balls) {
    row("balls kept", fmt::format("{} of nodes, clearance {:.3g}", counted(model.balls->pairs.size(), "pair"),
                                  model.balls->clearance));
  }
  return text + learned_summary(model);
}

std::string pose_table(const Model& model) {
  std::string text = fmt::format("\n{:>8}  reference  pose\n", "proven");
  for (const TrainedPose& pose : model.poses) {
    text += fmt::format("{:>6.1f} %  {:<9}  {}\n", 100 * pose.proven, pose.reference ? "yes" : "",
                        cell(pose.name));
  }
  return text;
}

std::string level_table(const ModelSummary& s) {
  std::string text = fmt::format("\n{:<8}{:>10}{:>12}{:>10}{:>14}{:>12}\n", "level", "nodes", "with chart",
                                 "charts", "kappa, median", "largest");
  const auto row = [&](const std::string& name, const ModelSummary::Level& level) {
    text += fmt::format("{:<8}{:>10}{:>12}{:>10}", name, grouped(level.slots), grouped(level.charted),
                        grouped(level.charts));
    if (level.charts > 0)
      text += fmt::format("{:>14.2f}{:>12.2f}", rounded_up(level.kappa_median), rounded_up(level.kappa_max));
    text += "\n";
  };
  for (std::size_t k = 0; k < s.levels.size(); ++k) row(std::to_string(k), s.levels[k]);
  row("pairs", s.pairs);
  return text;
}

std::string hard_table(const Model& model, const ModelSummary& s) {
  if (model.hard_leaves.empty()) return "\nEvery leaf is proven in every reference pose.\n";
  const std::vector<HardLeaf> leaves = sorted_hard_leaves(model);
  const auto always = std::count_if(leaves.begin(), leaves.end(),
                                    [&](const HardLeaf& leaf) { return leaf.references == s.references; });
  std::string text = fmt::format(
      "\nHard to prove: {} of {} leaves in some reference pose, {} in every one.\n", grouped(leaves.size()),
      grouped(model.hierarchy()->leaf_count()), grouped(static_cast<std::uint64_t>(always)));
  text += fmt::format("{:>10}  {:<11}  triangles\n", "poses", "why");
  for (std::size_t k = 0; k < std::min(leaves.size(), kListedLeaves); ++k) {
    const auto ids = triangles_of(model, leaves[k]);
    text += fmt::format("{:>10}  {:<11}  {}{}\n", fmt::format("{} of {}", leaves[k].references, s.references),
                        reason(leaves[k].obstacle),
                        fmt::join(ids.first(std::min<std::size_t>(ids.size(), 6)), " "),
                        ids.size() > 6 ? fmt::format(" and {} more", ids.size() - 6) : "");
  }
  return text;
}

Json to_json(const ModelSummary::Level& level) {
  Json json = {{"nodes", level.slots}, {"with_chart", level.charted}, {"charts", level.charts}};
  json["kappa_median"] = level.charts ? Json(rounded_up(level.kappa_median)) : Json(nullptr);
  json["kappa_largest"] = level.charts ? Json(rounded_up(level.kappa_max)) : Json(nullptr);
  return json;
}

Json to_json(const Model& model, const ModelSummary& s, std::uint64_t bytes) {
  const Topology& mesh = model.hierarchy()->topology();
  Json poses = Json::array(), levels = Json::array(), hard = Json::array();
  for (const TrainedPose& pose : model.poses) {
    poses.push_back({{"name", pose.name}, {"reference", pose.reference}, {"proven", pose.proven}});
  }
  for (const ModelSummary::Level& level : s.levels) levels.push_back(to_json(level));
  for (const HardLeaf& leaf : sorted_hard_leaves(model)) {
    hard.push_back(
        {{"references", leaf.references}, {"why", reason(leaf.obstacle)}, {"triangles", Json::array()}});
    for (const Index id : triangles_of(model, leaf)) hard.back()["triangles"].push_back(id);
  }
  return {{"foldproof", version()},
          {"model", model.name},
          {"trained_by", model.program},
          {"vertices", mesh.vertex_count()},
          {"triangles", mesh.triangles().size()},
          {"topology_hash", fmt::format("{:016x}", topology_hash(mesh))},
          {"bytes", bytes},
          {"charts", model.chart_count()},
          {"leaves", model.hierarchy()->leaf_count()},
          {"references", s.references},
          {"proven", s.proven},
          {"poses", poses},
          {"levels", levels},
          {"pairs", to_json(s.pairs)},
          {"hard_leaves", hard},
          {"balls", model.balls
                        ? Json({{"clearance", model.balls->clearance}, {"pairs", model.balls->pairs.size()}})
                        : Json(nullptr)},
          {"learned", learned_json(model)}};
}

Result<int> info(const InfoArguments& a) {
  FOLDPROOF_TRY(a.files.check());
  const auto model = FOLDPROOF_TRY(load_model(a.model));
  std::error_code unknown;
  const std::uint64_t bytes = std::filesystem::file_size(a.model, unknown);
  const ModelSummary s = summarize(model);
  if (a.json.empty()) {
    print_output(overview(model, s, bytes) + pose_table(model) + level_table(s) + hard_table(model, s) +
                 learned_tables(model));
    return kExitClean;
  }
  const std::string text =
      to_json(model, s, bytes).dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
  FOLDPROOF_TRY(io::write_file(a.json, text));
  return kExitClean;
}

}  // namespace

Command add_info(CommandLine& program) {
  const Subcommand command = program.add_subcommand("info", "Show what is inside a model");
  command.footer(kInfoFooter);
  const auto a = std::make_shared<InfoArguments>();
  a->files.reads(command.add_option("MODEL", a->model, "A file that 'foldproof train' wrote"))
      .type_name("")
      .required();
  a->files
      .writes(command.add_option("--json", a->json, "Write all of it as JSON; - is standard output"),
              FileArguments::Output::Text)
      .type_name("FILE");
  return [a] { return info(*a); };
}

}  // namespace foldproof
