#include "learned_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "terminal.h"

namespace foldproof {
namespace {

using Json = nlohmann::ordered_json;

/// How many badly represented poses and regions are listed.
constexpr std::size_t kListedRows = 5;

/// Over all poses: the mean of the means, and the worst.
struct Overall {
  double mean = 0, worst = 0;
};

template <class Get>
Overall overall(const Learned& learned, Get get) {
  Overall all;
  for (const LearnedPose& pose : learned.poses) {
    const VertexDistance d = get(pose);
    all.mean += d.mean / static_cast<double>(learned.poses.size());
    all.worst = std::max(all.worst, d.worst);
  }
  return all;
}

double share(double distance, double size) { return size > 0 ? distance / size : 0; }

const char* name(SubspaceKind kind) { return kind == SubspaceKind::KernelPca ? "kernel PCA" : "PCA"; }

Index triangles_below(const Model& model, Index node) {
  const Hierarchy& h = *model.hierarchy();
  return h.leaves()[h.nodes()[node].leaf_end].triangles - h.leaves()[h.nodes()[node].leaf_begin].triangles;
}

std::string badly_represented(const Model& model) {
  const Learned& learned = *model.learned;
  const auto poses = badly_represented_poses(learned), regions = badly_represented_regions(learned);
  std::string text;
  for (std::size_t k = 0; k < std::min(poses.size(), kListedRows); ++k) {
    const LearnedPose& pose = learned.poses[poses[k]];
    text += row(k == 0 ? "badly represented" : "",
                fmt::format("pose {}: mean {}", cell(model.poses[pose.pose].name),
                            distance_text(pose.leave_one_out.projection.mean, learned.size)));
  }
  for (std::size_t k = 0; k < std::min(regions.size(), kListedRows); ++k) {
    const LearnedRegion& region = learned.regions[regions[k]];
    text += row(poses.empty() && k == 0 ? "badly represented" : "",
                fmt::format("region around vertex {}: mean {}, {}", region.worst_vertex,
                            distance_text(region.mean, learned.size),
                            counted(triangles_below(model, region.node), "triangle")));
  }
  return text;
}

std::string certificate_row(const Learned& learned) {
  if (!learned.certificates) return "";
  const CertificateMap& map = *learned.certificates;
  // Always predicting the more frequent outcome is right everywhere only where each node has one outcome.
  if (map.majority_accuracy == 1)
    return row("certificates",
               fmt::format("{} nodes, each proven in all poses or in none: nothing to predict",
                           grouped(map.nodes.size())));
  return row(
      "certificates",
      fmt::format("{} nodes, balanced accuracy {:.0f} %  (majority {:.0f} %, chance 50 %)",
                  grouped(map.nodes.size()), 100 * map.balanced_accuracy, 100 * map.majority_accuracy));
}

Json to_json(const VertexDistance& d, double size) {
  Json json = {{"mean", d.mean}, {"worst", d.worst}};
  json["mean_share"] = share(d.mean, size);
  json["worst_share"] = share(d.worst, size);
  json["worst_vertex"] = d.worst_vertex == kNoIndex ? Json(nullptr) : Json(d.worst_vertex);
  return json;
}

Json to_json(const PoseError& e, double size) {
  return {{"projection", to_json(e.projection, size)},
          {"cueing", to_json(e.cueing, size)},
          {"total", to_json(e.total, size)}};
}

Json poses_json(const Model& model) {
  const Learned& learned = *model.learned;
  const auto bad = badly_represented_poses(learned);
  Json poses = Json::array();
  for (Index k = 0; k < learned.poses.size(); ++k) {
    const LearnedPose& pose = learned.poses[k];
    poses.push_back({{"pose", pose.pose},
                     {"name", model.poses[pose.pose].name},
                     {"cluster", learned.clusters.cluster_of[k]},
                     {"trained", to_json(pose.trained, learned.size)},
                     {"leave_one_out", to_json(pose.leave_one_out, learned.size)},
                     {"badly_represented", std::find(bad.begin(), bad.end(), k) != bad.end()}});
  }
  return poses;
}

Json regions_json(const Model& model) {
  const Learned& learned = *model.learned;
  const auto bad = badly_represented_regions(learned);
  Json regions = Json::array();
  for (Index k = 0; k < learned.regions.size(); ++k) {
    const LearnedRegion& r = learned.regions[k];
    regions.push_back({{"node", r.node},
                       {"triangles", triangles_below(model, r.node)},
                       {"mean", r.mean},
                       {"worst", r.worst},
                       {"worst_vertex", r.worst_vertex},
                       {"worst_pose", r.worst_pose},
                       {"badly_represented", std::find(bad.begin(), bad.end(), k) != bad.end()}});
  }
  return regions;
}

}  // namespace

std::string distance_text(double distance, double size) {
  return fmt::format("{:.3g}  ({:.2g} %)", distance, 100 * share(distance, size));
}

std::string learned_summary(const Model& model) {
  if (!model.learned) {
    return row("learned", "nothing" + (model.not_learned.empty() ? std::string() : ": " + model.not_learned));
  }
  const Learned& learned = *model.learned;
  const auto& keys = learned.key_points;
  const auto& energy = learned.kernel ? learned.kernel->energy : learned.pca.energy;
  std::string text =
      row("subspace", fmt::format("{}, {}  ({:.4g} % of the variance)", name(learned.settings.subspace),
                                  counted(static_cast<std::uint64_t>(energy.size()), "mode"),
                                  100 * energy[energy.size() - 1]));
  text += row("key points", fmt::format("{}  ({:.2g} % of the vertices, {})", grouped(keys.vertices.size()),
                                        100.0 * static_cast<double>(keys.vertices.size()) /
                                            model.hierarchy()->topology().vertex_count(),
                                        counted(keys.round_ends.size(), "round")));
  text += row("clusters of poses", grouped(learned.clusters.count()));
  text += certificate_row(learned);
  const auto error = [&](const char* label, const Overall& e) {
    text += row(label, fmt::format("mean {}, worst vertex {}", distance_text(e.mean, learned.size),
                                   distance_text(e.worst, learned.size)));
  };
  error("projection error", overall(learned, [](const auto& p) { return p.trained.projection; }));
  error("cueing error", overall(learned, [](const auto& p) { return p.trained.cueing; }));
  error("leave-one-out error", overall(learned, [](const auto& p) { return p.leave_one_out.projection; }));
  error("  from key points", overall(learned, [](const auto& p) { return p.leave_one_out.total; }));
  if (learned.kernel) text += row("", "leave-one-out errors are those of the linear subspace");
  return text + badly_represented(model);
}

std::string learned_tables(const Model& model) {
  if (!model.learned) return "";
  const Learned& learned = *model.learned;
  std::string text = fmt::format(
      "\nMean and worst vertex distance, mesh units (size {:.4g})\n{:>20}{:>20}{:>20}  {:<9}pose\n",
      learned.size, "projection", "cueing", "leave-one-out", "cluster");
  const auto both = [](const VertexDistance& d) { return fmt::format("{:.3g} {:.3g}", d.mean, d.worst); };
  for (std::size_t k = 0; k < learned.poses.size(); ++k) {
    const LearnedPose& pose = learned.poses[k];
    text += fmt::format("{:>20}{:>20}{:>20}  {:<9}{}\n", both(pose.trained.projection),
                        both(pose.trained.cueing), both(pose.leave_one_out.projection),
                        learned.clusters.cluster_of[k], cell(model.poses[pose.pose].name));
  }
  std::vector<Index> order(learned.regions.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return learned.regions[a].mean > learned.regions[b].mean; });
  if (order.size() > kListedRows) order.resize(kListedRows);
  text += fmt::format("\n{:>12}{:>12}  regions of largest leave-one-out error\n", "mean", "worst");
  for (const Index k : order) {
    const LearnedRegion& r = learned.regions[k];
    text += fmt::format("{:>12.3g}{:>12.3g}  around vertex {}, {}, worst in {}\n", r.mean, r.worst,
                        r.worst_vertex, counted(triangles_below(model, r.node), "triangle"),
                        cell(model.poses[r.worst_pose].name));
  }
  return text;
}

Json learned_json(const Model& model) {
  if (!model.learned) return nullptr;
  const Learned& learned = *model.learned;
  const auto list = [](const Eigen::VectorXd& x) { return std::vector<double>(x.begin(), x.end()); };
  Json json = {{"subspace", name(learned.settings.subspace)},
               {"size", learned.size},
               {"modes", learned.pca.modes()},
               {"energy", list(learned.pca.energy)},
               {"deviations", list(learned.pca.deviations)},
               {"key_points", learned.key_points.vertices},
               {"key_point_rounds", learned.key_points.round_ends},
               {"key_point_errors", learned.key_points.errors},
               {"clusters", learned.clusters.count()},
               {"silhouette", learned.clusters.silhouette}};
  json["certificates"] = nullptr;
  if (learned.certificates) {
    json["certificates"] = {{"nodes", learned.certificates->nodes.size()},
                            {"balanced_accuracy", learned.certificates->balanced_accuracy},
                            {"majority_accuracy", learned.certificates->majority_accuracy},
                            {"false_discovery_rate", learned.certificates->false_discovery_rate}};
  }
  json["poses"] = poses_json(model);
  json["regions"] = regions_json(model);
  return json;
}

}  // namespace foldproof
