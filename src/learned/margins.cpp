
#include <limits>

#include "base/parallel.h"
#include "certificate/chart_holds.h"
#include "learned/certificates.h"

namespace foldproof::internal {

std::vector<Index> depths_of(const Hierarchy& hierarchy) {
  const auto nodes = hierarchy.nodes();
  std::vector<Index> depths(nodes.size(), 0);
  for (Index n = 0; n < nodes.size(); ++n) {
    if (!nodes[n].is_leaf()) depths[n + 1] = depths[nodes[n].right] = depths[n] + 1;
  }
  return depths;
}

std::vector<Index> predictable_nodes(const ChartLibrary& charts, Index max_count) {
  const Hierarchy& h = *charts.slots()->hierarchy();
  const std::vector<Index> depths = depths_of(h);
  std::vector<Index> on_level;
  for (Index n = 0; n < depths.size(); ++n) {
    if (charts.first(n) == kNoIndex) continue;
    if (on_level.size() <= depths[n]) on_level.resize(depths[n] + 1, 0);
    ++on_level[depths[n]];
  }
  Index levels = 0, count = 0;
  while (levels < on_level.size() && count + on_level[levels] <= max_count) count += on_level[levels++];
  std::vector<Index> nodes;
  for (Index n = 0; n < depths.size(); ++n) {
    if (depths[n] < levels && charts.first(n) != kNoIndex) nodes.push_back(n);
  }
  return nodes;
}

struct MarginMeter::Scratch {
  explicit Scratch(std::shared_ptr<const ChartLibrary> library)
      : charts(std::move(library)), bvh(charts->slots()->hierarchy()) {}

  double margin(Index node) {
    double best = -1;
    for (Index c = charts->first(node); c != kNoIndex; c = charts->charts()[c].next) {
      const ChartView view = view_of(*charts, charts->charts()[c]);
      best = std::max(best, chart_margin(view, bvh.vertices, locals.local(), best));
    }
    return best;
  }

  std::shared_ptr<const ChartLibrary> charts;
  KineticBvh bvh;
  PerThread<ChartScratch> locals;
};

MarginMeter::MarginMeter(std::shared_ptr<const ChartLibrary> charts)
    : scratch_(std::make_unique<Scratch>(std::move(charts))) {}
MarginMeter::~MarginMeter() = default;
MarginMeter::MarginMeter(MarginMeter&&) noexcept = default;

Eigen::VectorXd MarginMeter::measure(std::span<const Index> nodes, std::span<const double> positions) {
  scratch_->bvh.refit(frame_around(positions), positions, positions);
  Eigen::VectorXd margins(static_cast<Eigen::Index>(nodes.size()));
  parallel_for(std::size_t{0}, nodes.size(),
               [&](std::size_t k) { margins[static_cast<Eigen::Index>(k)] = scratch_->margin(nodes[k]); });
  return margins;
}

}  // namespace foldproof::internal
