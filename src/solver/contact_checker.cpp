#include "solver/contact_checker.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/plain_arithmetic.h"
#include "base/try.h"
#include "solver/pair_distances.h"

namespace foldproof {
namespace {

// Steps to test at most until one is free with its end rounded (V3).
constexpr int kMaxTrials = 16;
// A trial that is not free is followed by one that ends before its contact, the first time by little.
constexpr double kFirstShorter = 63.0 / 64, kShorter = 1.0 / 2;
// Where something is too close at once, by one that is much shorter, as then the tolerance is less.
constexpr double kMuchShorter = 1.0 / 256;

}  // namespace

Result<void> internal::check_length(const char* name, double value) {
  if (!(value >= 0) || !std::isfinite(value))
    return fail(ErrorCode::InvalidArgument, name, "is not a length", "give a number of at least 0");
  return {};
}

ContactFilter::ContactFilter(const CollisionMesh& mesh, std::shared_ptr<const PairFilter> pairs)
    : filter_(mesh.filter()), pairs_(std::move(pairs)), triangles_(mesh.hierarchy()->topology().triangles()) {
  const auto groups = mesh.filter().vertex_groups();
  if (groups.empty()) return;
  std::vector<Index> first(*std::ranges::max_element(groups) + std::size_t{1}, kNoIndex);  // vertex of each
  for (Index v = 0; v < groups.size(); ++v) first[groups[v]] = std::min(first[groups[v]], v);
  const Hierarchy& hierarchy = *mesh.hierarchy();
  nodes_ = NodeLabels(hierarchy, [&](Index leaf, std::vector<Index>& out) {
    for_each_corner(hierarchy, leaf, [&](Index v) { out.push_back(first[groups[v]]); });
  });
}

bool ContactFilter::crossing(Index, Index triangle_a, Index, Index triangle_b) const {
  if (pairs_ != nullptr && !pairs_->crossing(0, triangle_a, 0, triangle_b)) return false;
  const Triangle &a = triangles_[triangle_a], &b = triangles_[triangle_b];
  const auto in = [](const Triangle& t, Index v) { return v == t[0] || v == t[1] || v == t[2]; };
  // Vertices that both have do not count, unless there are no others.
  const bool same = in(b, a[0]) && in(b, a[1]) && in(b, a[2]) && in(a, b[0]) && in(a, b[1]) && in(a, b[2]);
  for (const Index i : a) {
    for (const Index j : b) {
      if (same ? i == j : in(b, i) && in(a, j)) continue;
      if (filter_(i, j)) return true;
    }
  }
  return false;
}

StepSettings ContactChecker::Impl::step_settings(double distance) const {
  StepSettings step;
  step.certificates = settings.certificates;
  step.thickness = distance;
  step.tolerance = settings.tolerance;
  step.earliest_only = true;
  return step;
}

Result<void> ContactChecker::Impl::find_contacts(std::span<const double> x0, std::span<const double> x1,
                                                 const StepSettings& with, const Question& question) {
  FOLDPROOF_TRY(check_length("min_distance", question.min_distance));
  const std::span<const double> from[] = {x0}, to[] = {x1};
  const PairSettings pairs{settings.tolerance > 0 ? 0 : 0x1p-30, question.min_gap_share, question.max_gap};
  FOLDPROOF_TRY(run([&](Pipeline& used) {
    return check_step({used, nullptr, {}, question.any_will_do, &pairs}, from, to, with, step);
  }));
  work += step.work;
  milliseconds += step.milliseconds;
  return {};
}

Result<double> ContactChecker::Impl::earliest_contact(std::span<const double> x0, std::span<const double> x1,
                                                      const Question& question) {
  FOLDPROOF_TRY(find_contacts(x0, x1, step_settings(question.min_distance), question));
  return step.clean() ? std::numeric_limits<double>::infinity() : step.earliest_toi;
}

ContactChecker::ContactChecker(std::shared_ptr<const CollisionMesh> mesh, const ContactSettings& settings,
                               std::shared_ptr<const PairFilter> filter)
    : impl_(new Impl(std::move(mesh), settings, std::move(filter))) {}
ContactChecker::~ContactChecker() = default;
ContactChecker::ContactChecker(ContactChecker&&) noexcept = default;
ContactChecker& ContactChecker::operator=(ContactChecker&&) noexcept = default;

const CollisionMesh& ContactChecker::mesh() const { return *impl_->mesh; }
ContactSettings& ContactChecker::settings() { return impl_->settings; }
const Work& ContactChecker::work() const { return impl_->work; }
const StageTimes& ContactChecker::milliseconds() const { return impl_->milliseconds; }

Result<StepSize> ContactChecker::collision_free_step_size(std::span<const double> x0,
                                                          std::span<const double> x1, double min_distance) {
  const PlainArithmetic plain;
  impl_->start_call();
  FOLDPROOF_TRY(impl_->check_rescaling());
  const double contact = FOLDPROOF_TRY(impl_->earliest_contact(x0, x1, {min_distance}));
  if (contact > 1) return StepSize{1, StepSize::Limit::None};
  const StepSize size = impl_->limited(x0, x1);
  const Impl::Question shorter = impl_->shorter_step(x0, x1, min_distance);
  // In place a pair's tolerance is the least.
  if (contact > 0 || FOLDPROOF_TRY(impl_->earliest_contact(x0, x0, {min_distance})) > 1)
    return impl_->shortened(x0, x1, shorter, size);
  StepSize none = impl_->limited(x0, x0);
  if (none.limit == StepSize::Limit::Contact) none.limit = StepSize::Limit::Start;
  return none;
}

Result<void> ContactChecker::Impl::check_rescaling() const {
  const double rescaling = settings.conservative_rescaling;
  if (rescaling > 0 && rescaling <= 1) return {};
  return fail(ErrorCode::InvalidArgument, "conservative_rescaling", "is not a share of the way",
              "give a number above 0 and at most 1");
}

ContactChecker::Impl::Question ContactChecker::Impl::shorter_step(std::span<const double> x0,
                                                                  std::span<const double> x1,
                                                                  double min_distance) const {
  if (!settings.rescale_distance) return {min_distance};
  const double share = 1 - settings.conservative_rescaling;
  return {min_distance, share, share * std::max(0.0, closest(x0, x1, 0).distance - min_distance)};
}

Result<StepSize> ContactChecker::Impl::shortened(std::span<const double> x0, std::span<const double> x1,
                                                 const Question& question, StepSize size) {
  double contact = size.contact_time, share = 1, shorter = settings.conservative_rescaling;
  end_positions.resize(x0.size());
  for (int trial = 0; trial < kMaxTrials && share > 0; ++trial) {
    share *= contact > 0 ? shorter * contact : kMuchShorter;
    step_towards(x0, x1, share, end_positions);
    contact = FOLDPROOF_TRY(earliest_contact(x0, end_positions, question));
    if (contact > 1) {
      size.share = share;
      return size;
    }
    if (settings.rescale_distance && trial == 0) {  // another pair may come to its share first
      size = limited(x0, end_positions);
      size.contact_time *= share;
    }
    shorter = trial == 0 ? kFirstShorter : kShorter;
  }
  size.limit = StepSize::Limit::Undecided;
  return size;
}

StepSize ContactChecker::Impl::limited(std::span<const double> x0, std::span<const double> x1) const {
  const Answer answer = step.vertex_face.empty() ? step.edge_edge[0].answer : step.vertex_face[0].answer;
  return {0, answer == Answer::Hit ? StepSize::Limit::Contact : StepSize::Limit::Undecided, step.earliest_toi,
          closest(x0, x1, step.earliest_toi)};
}

ClosePair ContactChecker::Impl::closest(std::span<const double> x0, std::span<const double> x1,
                                        double time) const {
  const bool edge_edge = step.vertex_face.empty();
  std::array<Index, 4> ids;
  if (edge_edge) {
    const auto& [a, b] = std::pair(step.edge_edge[0].a, step.edge_edge[0].b);
    ids = {a[0], a[1], b[0], b[1]};
  } else {
    const Triangle& t = mesh->hierarchy()->topology().triangles()[step.vertex_face[0].face];
    ids = {step.vertex_face[0].vertex, t[0], t[1], t[2]};
  }
  PairBatch batch{};
  for (int k = 0; k < 4; ++k) {
    const auto from_first = [&](std::span<const double> x) {
      return position(x, ids[k]) - position(x, ids[0]);
    };
    const Vec3 at = (1 - time) * from_first(x0) + time * from_first(x1);
    for (int axis = 0; axis < 3; ++axis) batch.x[0][k][axis][0] = at[axis];
  }
  NearestBatch nearest;
  nearest_points(batch, 1, edge_edge, std::numeric_limits<double>::infinity(), nearest);
  return close_pair(ids, edge_edge, nearest, 0);
}

Verdict ContactChecker::is_step_collision_free(std::span<const double> x0, std::span<const double> x1,
                                               double min_distance) {
  impl_->start_call();
  return impl_->earliest_contact(x0, x1, {.min_distance = min_distance, .any_will_do = true})
      .map([](double contact) { return contact > 1; });
}

Verdict ContactChecker::has_intersections(std::span<const double> x) {
  impl_->start_call();
  Impl& m = *impl_;
  const std::span<const double> pose[] = {x};
  StepSettings settings = m.step_settings(0);
  settings.max_listed = 0;  // whether there is one is all that matters
  const auto done = m.run([&](Pipeline& used) {
    return check_pose({used, nullptr, {}, true}, pose, settings, m.pose);
  });
  if (!done) return Result<bool>(tl::unexpected(done.error()));
  m.work = m.pose.work;
  m.milliseconds = m.pose.milliseconds;
  return Result<bool>(!m.pose.clean());
}

void step_towards(std::span<const double> x0, std::span<const double> x1, double share,
                  std::span<double> out) {
  const PlainArithmetic plain;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = share == 1 ? x1[i] : x0[i] + share * (x1[i] - x0[i]);
}

}  // namespace foldproof
