#include "page/radius.h"

#include <algorithm>
#include <cmath>

#include "foldproof/reduced.h"
#include "page/page_json.h"

namespace foldproof {
namespace {

std::vector<Index> triangles_of(const Hierarchy& hierarchy, std::span<const UncertifiedPair> pairs) {
  std::vector<Index> triangles;
  for (const UncertifiedPair& pair : pairs) {
    for (const Index leaf : {pair.leaf_a, pair.leaf_b}) {
      const Index end = hierarchy.leaves()[leaf + 1].triangles;
      for (Index k = hierarchy.leaves()[leaf].triangles; k < end; ++k)
        triangles.push_back(hierarchy.triangle_ids()[k]);
    }
  }
  std::sort(triangles.begin(), triangles.end());
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  return triangles;
}

}  // namespace

Json RadiusService::request(Index object) {
  const std::lock_guard lock(mutex_);
  Entry& entry = entries_[object];
  if (entry.state == Entry::State::Idle) {
    entry.state = Entry::State::Queued;
    queued_.notify_one();
  }
  const bool done = entry.state == Entry::State::Done, failed = entry.state == Entry::State::Failed;
  return {{"state", done     ? "done"
                    : failed ? "failed"
                             : "computing"},
          {"progress", entry.progress},
          {"radius", entry.radius},
          {"share", entry.share},
          {"uncertified", entry.uncertified},
          {"uncertified_triangles", entry.uncertified_triangles},
          {"error", entry.error}};
}

bool RadiusService::compute_queued(const std::atomic<bool>& stop) {
  std::unique_lock lock(mutex_);
  const auto next = std::ranges::find(entries_, Entry::State::Queued, &Entry::state);
  if (next == entries_.end()) return false;
  lock.unlock();
  Entry entry{.state = Entry::State::Failed};
  try {
    entry = compute(static_cast<Index>(next - entries_.begin()), stop);
  } catch (const std::exception& error) {
    entry.error = line_of(error);
  }
  lock.lock();
  *next = std::move(entry);
  return true;
}

void RadiusService::wait() {
  std::unique_lock lock(mutex_);
  // Not for longer: a signal handler cannot notify.
  queued_.wait_for(lock, std::chrono::milliseconds(50));
}

RadiusService::Entry RadiusService::compute(Index object, const std::atomic<bool>& stop) {
  const auto failed = [](const Error& error) {
    return Entry{.state = Entry::State::Failed, .error = error.line()};
  };
  const PageObject& shown = *scene_.objects()[object];
  auto motion = ReducedMotion::make(shown.hierarchy, shown.learned()->pca);
  if (!motion) return failed(motion.error());
  const std::vector<double> mean(motion->modes(), 0);
  // Covers the training poses with a margin; larger radii are not needed.
  double max_radius = std::sqrt(motion->modes()) + 4.0;
  const Eigen::MatrixXd& poses = shown.learned()->coordinates;
  for (Eigen::Index k = 0; k < poses.cols(); ++k)
    max_radius = std::max(max_radius, 1.1 * shown.learned()->pca.mahalanobis(poses.col(k)));
  ReducedHooks hooks;
  hooks.progress = [&](double part) {
    const std::lock_guard lock(mutex_);
    entries_[object].progress = part;
  };
  hooks.cancel = &stop;
  const auto shape = ReducedShape::build(std::make_shared<const ReducedMotion>(std::move(*motion)),
                                         {{mean, max_radius}}, {}, hooks);
  if (!shape) return failed(shape.error());
  const double radius = shape->radius(0);
  return {.state = Entry::State::Done,
          .progress = 1,
          .radius = radius,
          .share = normal_share(radius, shape->motion()->modes()),
          .uncertified = shape->uncertified(0).size(),
          .uncertified_triangles = triangles_of(*shown.hierarchy, shape->uncertified(0))};
}

}  // namespace foldproof
