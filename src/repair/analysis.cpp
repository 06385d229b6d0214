#include "repair/analysis.h"

#include <algorithm>

#include "base/try.h"

namespace foldproof {
namespace {

constexpr int kTouchedRings = 3;

// The contacts of a pose; the prover's last answer was about it.
Result<ContactFinder> find_in_pose(const RepairScene& scene, const StaticResult& crossings,
                                   std::span<const double> x, std::vector<std::span<const double>>& views) {
  auto finder = FOLDPROOF_TRY(ContactFinder::make(scene.topologies(), {}, scene.filter()));
  finder.start(0, scene.positions(x, views), crossings);
  return finder;
}

// Calls mark(contact, vertex) for the vertices of all that crosses or is inside now.
template <class Mark>
void for_contact_vertices(const RepairScene& scene, const ContactFinder& finder, const Mark& mark) {
  const auto mark_triangle = [&](Index contact, Index object, Index triangle) {
    for (const Index v : scene.triangles()[scene.begin(object).triangles + std::size_t{triangle}])
      mark(contact, v);
  };
  const auto crossings = finder.crossings();
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    const Index contact = finder.crossing_contacts()[i];
    mark_triangle(contact, crossings[i].object_a, crossings[i].triangle_a);
    mark_triangle(contact, crossings[i].object_b, crossings[i].triangle_b);
  }
  for (const auto& inside : finder.inside()) mark_triangle(inside.contact, inside.object, inside.triangle);
}

// The mean of its neighbors at each marked vertex, all others as in x: Gauss and Seidel with overrelaxation.
std::vector<double> fill(const RepairScene& scene, const std::vector<std::uint8_t>& mask,
                         std::span<const double> x) {
  constexpr int kSweeps = 400;
  constexpr double kOver = 1.8;
  std::vector<double> y(x.begin(), x.end());
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (Index v = 0; v < mask.size(); ++v) {
      const auto around = scene.neighbors()[v];
      if (mask[v] == 0 || !scene.is_movable(v) || around.empty()) continue;
      Vec3 mean;
      for (const Index u : around) mean += at(y, u);
      mean /= static_cast<double>(around.size());
      put(y, v, at(y, v) + kOver * (mean - at(y, v)));
    }
  }
  return y;
}

}  // namespace

void internal::dilate(const RepairScene& scene, std::vector<std::uint8_t>& mask, int rings) {
  std::vector<Index> front, next;
  for (Index v = 0; v < mask.size(); ++v) {
    if (mask[v] != 0) front.push_back(v);
  }
  for (int ring = 0; ring < rings; ++ring) {
    next.clear();
    for (const Index v : front) {
      for (const Index u : scene.neighbors()[v]) {
        if (mask[u] == 0) mask[u] = 1, next.push_back(u);
      }
    }
    front.swap(next);
  }
}

void Analysis::touch(Frame& frame, const StepResult& step) const {
  const auto add = [&](const FeaturePair& pair) {
    frame.touched.insert(frame.touched.end(), pair.v.begin(), pair.v.end());
  };
  for (const auto& c : step.vertex_face) add(scene_->pair_of(c));
  for (const auto& c : step.edge_edge) add(scene_->pair_of(c));
}

void Analysis::touch_crossings(Frame& frame) const {
  for_contact_vertices(*scene_, *finder_, [&](Index, Index v) { frame.touched.push_back(v); });
}

Result<void> Analysis::add(double time, std::span<const double> x) {
  Frame frame;
  const Positions positions = scene_->positions(x, views_);
  if (frames_.empty()) {
    finder_ = FOLDPROOF_TRY(ContactFinder::make(scene_->topologies(), {}, scene_->filter()));
    finder_->start(time, positions, *FOLDPROOF_TRY(prover_->check_pose(x)));
    frame.is_way_free = true;
  } else {
    const StepResult* step = FOLDPROOF_TRY(prover_->check(last_, x));
    frame.is_way_free = step->clean();
    touch(frame, *step);
    touch(frames_.back(), *step);
    const bool asks = !step->lists_all() || !finder_->is_known();
    const StaticResult* crossings = asks ? FOLDPROOF_TRY(prover_->check_pose(x)) : nullptr;
    finder_->step(last_time_, time, scene_->positions(last_, last_views_), positions, *step, crossings);
  }
  frame.crossings = finder_->crossings().size();
  touch_crossings(frame);
  for (Contact& contact : finder_->take_ended()) ended_.push_back(std::move(contact));
  frame.is_free = frame.crossings == 0 && finder_->is_known();
  if (thickness_ > 0 && frame.is_free) {
    const StepResult* near = FOLDPROOF_TRY(prover_->check(x, x));
    frame.is_free = near->clean();
    touch(frame, *near);
  }
  frames_.push_back(std::move(frame));
  for (auto& f : std::span(frames_).last(std::min<std::size_t>(2, frames_.size()))) {
    std::ranges::sort(f.touched);
    f.touched.erase(std::unique(f.touched.begin(), f.touched.end()), f.touched.end());
  }
  last_.assign(x.begin(), x.end());
  last_time_ = time;
  return {};
}

std::vector<Contact> Analysis::finish() {
  for (Contact& contact : finder_->finish()) ended_.push_back(std::move(contact));
  std::ranges::sort(ended_, {}, &Contact::number);
  return std::move(ended_);
}

bool Analysis::all_free() const {
  return std::ranges::all_of(frames_, [](const Frame& f) { return f.is_free && f.is_way_free; });
}

const std::vector<std::uint8_t>& Analysis::touched(std::size_t k) {
  if (mask_of_ == k) return mask_;
  mask_.assign(scene_->vertex_count(), 0);
  for (const Index v : frames_[k].touched) mask_[v] = 1;
  dilate(*scene_, mask_, kTouchedRings);
  mask_of_ = k;
  return mask_;
}

Result<std::vector<Index>> internal::contact_zones(const RepairScene& scene, Prover& prover,
                                                   std::span<const double> x, int rings) {
  const StaticResult* crossings = FOLDPROOF_TRY(prover.check_pose(x));
  std::vector<std::span<const double>> views;
  const auto finder = FOLDPROOF_TRY(find_in_pose(scene, *crossings, x, views));
  std::vector<std::pair<Index, Index>> marks;
  for_contact_vertices(scene, finder, [&](Index contact, Index v) { marks.emplace_back(contact, v); });
  std::ranges::sort(marks);
  std::vector<Index> zone(scene.vertex_count(), 0), joined{0};
  const auto root = [&](Index i) {
    while (joined[i] != i) i = joined[i] = joined[joined[i]];
    return i;
  };
  for (std::size_t i = 0; i < marks.size();) {
    std::vector<std::uint8_t> mask(zone.size(), 0);
    const Index contact = marks[i].first, number = static_cast<Index>(joined.size());
    joined.push_back(number);
    for (; i < marks.size() && marks[i].first == contact; ++i) mask[marks[i].second] = 1;
    dilate(scene, mask, rings);
    for (Index v = 0; v < zone.size(); ++v) {
      if (mask[v] == 0) continue;
      if (zone[v] != 0) joined[root(number)] = root(zone[v]);
      zone[v] = number;
    }
  }
  for (Index& z : zone) z = root(z);
  return zone;
}

Result<std::optional<std::vector<double>>> internal::untangle(const RepairScene& scene, Prover& prover,
                                                              std::span<const double> x) {
  constexpr int kMaxRounds = 8, kFirstRings = 2;
  std::vector<double> y(x.begin(), x.end());
  std::vector<std::uint8_t> bad(scene.vertex_count(), 0);
  std::vector<std::span<const double>> views;
  int rings = kFirstRings;
  for (int round = 0; round < kMaxRounds; ++round, rings = std::max(rings + 1, rings * 7 / 5)) {
    const StaticResult* crossings = FOLDPROOF_TRY(prover.check_pose(y));
    if (crossings->clean()) return y;
    const auto finder = FOLDPROOF_TRY(find_in_pose(scene, *crossings, y, views));
    for_contact_vertices(scene, finder, [&](Index, Index v) { bad[v] = 1; });
    auto mask = bad;
    dilate(scene, mask, rings);
    y = fill(scene, mask, x);
  }
  return FOLDPROOF_TRY(prover.is_free(y)) ? std::optional(std::move(y)) : std::nullopt;
}

}  // namespace foldproof
