#include "repair/analysis.h"

#include <algorithm>

#include "base/try.h"
#include "contacts/follow_crossings.h"

namespace foldproof {
namespace {

constexpr int kTouchedRings = 3;

template <class Item>
void append(const std::vector<Item>& from, std::vector<Item>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

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
    for (const Index v : scene.triangle(object, triangle)) mark(contact, v);
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

Analysis::Analysis(const RepairScene& scene, Prover& prover, double thickness, bool keeps_seams)
    : scene_(&scene), prover_(&prover), thickness_(thickness), keeps_seams_(keeps_seams) {
  if (scene.fixed_filter() != nullptr) fixed_prover_.emplace(scene, scene.fixed_filter(), 0);
}

void Analysis::touch(Frame& frame, const StepResult& step) const {
  std::vector<FeaturePair> pairs;
  scene_->pairs_of(step, pairs);
  for (const FeaturePair& pair : pairs)
    frame.touched.insert(frame.touched.end(), pair.v.begin(), pair.v.end());
}

void Analysis::touch_crossings(Frame& frame) const {
  for_contact_vertices(*scene_, *finder_, [&](Index contact, Index v) {
    if (movable_contacts_.contains(contact)) frame.touched.push_back(v);
  });
}

// Both answers as one.
Result<const StaticResult*> Analysis::all_crossings(std::span<const double> x) {
  const StaticResult* pose = FOLDPROOF_TRY(prover_->check_pose(x));
  if (!fixed_prover_) return pose;
  all_crossings_ = *pose;
  const StaticResult* fixed = FOLDPROOF_TRY(fixed_prover_->check_pose(x));
  append(fixed->crossings, all_crossings_.crossings);
  std::ranges::sort(all_crossings_.crossings, is_before);
  all_crossings_.crossing_count += fixed->crossing_count;
  return &all_crossings_;
}

Result<const StepResult*> Analysis::with_fixed(const StepResult& step, std::span<const double> x) {
  if (!fixed_prover_) return &step;
  const StepResult* fixed = FOLDPROOF_TRY(fixed_prover_->check(last_, x));
  all_pairs_ = step;
  append(fixed->vertex_face, all_pairs_.vertex_face);
  append(fixed->edge_edge, all_pairs_.edge_edge);
  all_pairs_.vertex_face_count += fixed->vertex_face_count;
  all_pairs_.edge_edge_count += fixed->edge_edge_count;
  return &all_pairs_;
}

bool Analysis::moves(std::span<const Index> a, std::span<const Index> b) const {
  const auto moves = [&](Index v) { return scene_->is_movable(v); };
  return std::ranges::any_of(a, moves) || std::ranges::any_of(b, moves);
}

// Calls visit(contact, a, b), with the vertices of two features or triangles, for what touches on the step,
// which may be null, and what crosses at its end.
template <class Visit>
void Analysis::for_touching(const StepResult* step, const Visit& visit) const {
  const auto of_pairs = [&](const auto& pairs, std::span<const Index> contacts) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const FeaturePair pair = scene_->pair_of(pairs[i]);
      const std::size_t n = pair.edges ? 2 : 1;
      visit(contacts[i], std::span(pair.v).first(n), std::span(pair.v).subspan(n));
    }
  };
  if (step != nullptr) {
    of_pairs(step->vertex_face, finder_->vertex_face_contacts());
    of_pairs(step->edge_edge, finder_->edge_edge_contacts());
  }
  for (std::size_t i = 0; i < finder_->crossings().size(); ++i) {
    const TriangleCrossing& c = finder_->crossings()[i];
    visit(finder_->crossing_contacts()[i], scene_->triangle(c.object_a, c.triangle_a),
          scene_->triangle(c.object_b, c.triangle_b));
  }
}

// Remembers the contacts in which something that may move takes part now.
void Analysis::note_movable(const StepResult* step) {
  std::set<Index> joined;
  for (const Index number : movable_contacts_) joined.insert(finder_->joined_number(number));
  movable_contacts_.swap(joined);
  for_touching(step, [&](Index contact, std::span<const Index> a, std::span<const Index> b) {
    if (moves(a, b)) movable_contacts_.insert(contact);
  });
}

// `step`: the prover's answer about the way to x; null for the first frame.
Result<void> Analysis::find_contacts(double time, std::span<const double> x, const StepResult* step) {
  const Positions positions = scene_->positions(x, views_);
  if (step == nullptr) {
    finder_ =
        FOLDPROOF_TRY(ContactFinder::make(scene_->topologies(), scene_->parts(), scene_->given_filter()));
    finder_->start(time, positions, *FOLDPROOF_TRY(all_crossings(x)));
  } else {
    step = FOLDPROOF_TRY(with_fixed(*step, x));
    const bool asks = !step->lists_all() || !finder_->is_known();
    const StaticResult* crossings = asks ? FOLDPROOF_TRY(all_crossings(x)) : nullptr;
    finder_->step(last_time_, time, scene_->positions(last_, last_views_), positions, *step, crossings);
  }
  note_movable(step);
  if (notes_seams_) note_seams(step);
  return {};
}

Result<void> Analysis::add(double time, std::span<const double> x) {
  Frame frame;
  const StepResult* step = nullptr;
  if (!frames_.empty()) {
    step = FOLDPROOF_TRY(prover_->check(last_, x));
    touch(frame, *step);
    touch(frames_.back(), *step);
  }
  frame.is_way_free = step == nullptr || step->clean();
  FOLDPROOF_TRY(find_contacts(time, x, step));
  for_touching(nullptr, [&](Index contact, std::span<const Index> a, std::span<const Index> b) {
    frame.contacts.insert(contact);
    if (moves(a, b)) ++frame.crossings;
  });
  if (!finder_->is_known()) frame.crossings = FOLDPROOF_TRY(prover_->check_pose(x))->crossing_count;
  touch_crossings(frame);
  if (frame.crossings == 0 && !keeps_seams_) notes_seams_ = false, seams_.clear();
  for (Contact& contact : finder_->take_ended()) ended_.push_back(std::move(contact));
  frame.is_free = frame.crossings == 0;
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

Result<Analysis::Contacts> Analysis::finish() {
  if (frames_.size() == 1 && thickness_ > 0)  // no step finds what is closer than the thickness
    FOLDPROOF_TRY(find_contacts(last_time_, last_, FOLDPROOF_TRY(prover_->check(last_, last_))));
  for (Contact& contact : finder_->finish()) ended_.push_back(std::move(contact));
  std::ranges::sort(ended_, {}, &Contact::number);
  sort_seams();
  Contacts out;
  for (Contact& contact : ended_) {
    const bool moves = movable_contacts_.contains(contact.number);
    (moves ? out.of_movable : out.among_fixed).push_back(std::move(contact));
  }
  return out;
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

std::set<Index> Analysis::crossing_contacts(std::size_t k) const {
  std::set<Index> out;
  for (const Index contact : frames_[k].contacts) out.insert(finder_->joined_number(contact));
  return out;
}

std::vector<std::array<ObjectVertex, 2>> Analysis::seams(const std::set<Index>& contacts,
                                                         const std::set<Index>& not_in) const {
  std::set<std::array<Index, 2>> others;
  for (const Seam& seam : seams_) {
    if (not_in.contains(finder_->joined_number(seam.contact))) others.insert(seam.ends);
  }
  std::vector<std::array<ObjectVertex, 2>> seams;
  const auto place = [&](Index v) {
    const Index object = scene_->object_of_vertex(v);
    return ObjectVertex{object, v - scene_->begin(object).vertices};
  };
  for (const Seam& seam : seams_) {
    if (contacts.contains(finder_->joined_number(seam.contact)) && !others.contains(seam.ends))
      seams.push_back({place(seam.ends[0]), place(seam.ends[1])});
  }
  return seams;
}

// Pairs of vertices of what touches now.
void Analysis::note_seams(const StepResult* step) {
  for_touching(step, [&](Index contact, std::span<const Index> a, std::span<const Index> b) {
    for (const Index u : a) {
      for (const Index v : b) {
        if (u != v) seams_.push_back({contact, {std::min(u, v), std::max(u, v)}});
      }
    }
  });
  if (seams_.size() > 2 * distinct_seams_) sort_seams();
}

void Analysis::sort_seams() {
  std::sort(seams_.begin(), seams_.end());
  seams_.erase(std::unique(seams_.begin(), seams_.end()), seams_.end());
  distinct_seams_ = seams_.size();
}

Result<std::optional<std::vector<double>>> internal::untangle(const RepairScene& scene, Prover& prover,
                                                              std::span<const double> x) {
  constexpr int kMaxRounds = 8, kFirstRings = 2;
  constexpr std::uint64_t kMostGrowth = 4;  // of crossings: beyond it, surfaces are filled into each other
  std::uint64_t most = 0;
  std::vector<double> y(x.begin(), x.end());
  std::vector<std::uint8_t> bad(scene.vertex_count(), 0);
  std::vector<std::span<const double>> views;
  int rings = kFirstRings;
  for (int round = 0; round < kMaxRounds; ++round, rings = std::max(rings + 1, rings * 7 / 5)) {
    const StaticResult* crossings = FOLDPROOF_TRY(prover.check_pose(y));
    if (crossings->clean()) return y;
    if (round == 0) most = kMostGrowth * crossings->crossing_count;
    if (crossings->crossing_count > most) return std::nullopt;
    const auto finder = FOLDPROOF_TRY(find_in_pose(scene, *crossings, y, views));
    for_contact_vertices(scene, finder, [&](Index, Index v) { bad[v] = 1; });
    auto mask = bad;
    dilate(scene, mask, rings);
    y = fill(scene, mask, x);
  }
  return FOLDPROOF_TRY(prover.check_pose(y))->clean() ? std::optional(std::move(y)) : std::nullopt;
}

}  // namespace foldproof
