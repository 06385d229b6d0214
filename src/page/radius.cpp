#include "page/radius.h"

#include <algorithm>
#include <cmath>

#include "foldproof/reduced.h"

namespace foldproof {

Json RadiusDesk::ask(Index object) {
  const std::lock_guard lock(mutex_);
  Entry& entry = entries_[object];
  if (entry.state == Entry::State::Idle) {
    entry.state = Entry::State::Ordered;
    ordered_.notify_one();
  }
  const bool done = entry.state == Entry::State::Done, failed = entry.state == Entry::State::Failed;
  return {{"state", done     ? "done"
                    : failed ? "failed"
                             : "computing"},
          {"progress", entry.progress},
          {"radius", entry.radius},
          {"share", entry.share},
          {"left_out", entry.left_out},
          {"error", entry.error}};
}

void RadiusDesk::work(const std::atomic<bool>& stop) {
  const auto is_ordered = [](const Entry& e) { return e.state == Entry::State::Ordered; };
  std::unique_lock lock(mutex_);
  while (!stop) {
    const auto next = std::find_if(entries_.begin(), entries_.end(), is_ordered);
    if (next == entries_.end()) {
      // A signal handler sets `stop` and cannot wake anybody.
      ordered_.wait_for(lock, std::chrono::milliseconds(50));
      continue;
    }
    lock.unlock();
    Entry found = this->find(static_cast<Index>(next - entries_.begin()), stop);
    lock.lock();
    *next = std::move(found);
  }
}

RadiusDesk::Entry RadiusDesk::find(Index object, const std::atomic<bool>& stop) {
  const auto failed = [](const Error& error) {
    return Entry{.state = Entry::State::Failed, .error = error.line()};
  };
  const PageObject& asked = *scene_.objects()[object];
  auto motion = ReducedMotion::make(asked.hierarchy, asked.learned()->pca);
  if (!motion) return failed(motion.error());
  const std::vector<double> mean(motion->modes(), 0);
  // As far as any training pose lies: no slider goes farther.
  double reach = std::sqrt(motion->modes()) + 4.0;
  const Eigen::MatrixXd& poses = asked.learned()->coordinates;
  for (Eigen::Index k = 0; k < poses.cols(); ++k)
    reach = std::max(reach, 1.1 * asked.learned()->pca.mahalanobis(poses.col(k)));
  ReducedHooks hooks;
  hooks.progress = [&](double part) {
    const std::lock_guard lock(mutex_);
    entries_[object].progress = part;
  };
  hooks.cancel = &stop;
  const auto shape = ReducedShape::build(std::make_shared<const ReducedMotion>(std::move(*motion)),
                                         {{mean, reach}}, {}, hooks);
  if (!shape) return failed(shape.error());
  const double radius = shape->radius(0);
  return {.state = Entry::State::Done,
          .progress = 1,
          .radius = radius,
          .share = normal_share(radius, shape->motion()->modes()),
          .left_out = shape->left_out(0).size()};
}

}  // namespace foldproof
