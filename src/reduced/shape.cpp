#include "reduced/shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/plain_arithmetic.h"
#include "base/try.h"
#include "reduced/touch_test.h"

namespace foldproof {
namespace {

Result<void> check_centers(const ReducedMotion& motion, std::vector<ReducedCenter>& centers) {
  if (centers.empty())
    return fail(ErrorCode::InvalidArgument, "centers", "there are none",
                "give at least one, such as the mean");
  for (std::size_t c = 0; c < centers.size(); ++c) {
    const auto where = fmt::format("center {}", c);
    if (centers[c].p.size() != motion.modes()) {
      return fail(ErrorCode::InvalidArgument, where, fmt::format("has {} numbers", centers[c].p.size()),
                  fmt::format("give {}, one per mode", motion.modes()));
    }
    for (const double p : centers[c].p) {
      if (!std::isfinite(p))
        return fail(ErrorCode::NonFinite, where, "has a number that is not finite", "repair it");
    }
    double& max_radius = centers[c].max_radius;
    if (!(max_radius >= 0) || !std::isfinite(max_radius))
      return fail(ErrorCode::InvalidArgument, where, "has a largest radius that is no distance",
                  "give a number of at least 0");
    if (max_radius == 0) max_radius = std::sqrt(motion.modes()) + 4.0;
  }
  return {};
}

// R5: squares of sizes and of motions neither overflow nor lose what is not far below the rounding error.
Result<void> check_range(const ReducedMotion& motion, std::span<const CenterPose> poses) {
  constexpr double kLargest = 1e70, kSmallest = 1e-70;
  // Infinity less infinity is no number, which no comparison of coordinates notices.
  const auto fits = [](const CenterPose& pose) {
    return std::isfinite(pose.rounding) && pose.max_coordinate >= kSmallest &&
           pose.max_coordinate <= kLargest;
  };
  if (motion.max_coordinate(motion.deviations()) <= kLargest && std::ranges::all_of(poses, fits)) return {};
  return fail(ErrorCode::LimitExceeded, "subspace",
              fmt::format("has shapes or deviations outside {} to {}", kSmallest, kLargest),
              "choose another unit of length");
}

double size_of(const CenterPose& pose) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = 0; i < pose.x.size(); i += 3) {
    const Vec3 x = Vec3::load(&pose.x[i]);
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).maxCoeff();
}

// All but the balls. Error: centers or numbers that do not fit.
Result<std::shared_ptr<ReducedShape::Impl>> start_shape(std::shared_ptr<const ReducedMotion> motion,
                                                        std::vector<ReducedCenter> centers,
                                                        std::vector<CenterPose>& poses) {
  FOLDPROOF_TRY(check_centers(*motion, centers));
  poses.reserve(centers.size());
  for (const ReducedCenter& center : centers) poses.emplace_back(*motion, center.p);
  FOLDPROOF_TRY(check_range(*motion, poses));
  auto impl = std::make_shared<ReducedShape::Impl>();
  impl->nodes = std::make_shared<const NodeMotions>(*motion, poses);
  for (const double deviation : motion->deviations()) impl->inverse_deviations.push_back(1 / deviation);
  impl->centers = std::move(centers);
  impl->motion = std::move(motion);
  return impl;
}

}  // namespace

void ReducedShape::Impl::use(ReducedBalls given, std::span<const CenterPose> poses) {
  balls = std::move(given);
  const std::shared_ptr<const Hierarchy>& hierarchy = motion->hierarchy();
  auto tree = make_pair_tree(*hierarchy, centers, balls);
  for (std::size_t c = 0; c < centers.size(); ++c) {
    const TouchTest test(*hierarchy, poses[c]);
    auto& pairs = uncertified.emplace_back();
    for (const auto& [a, b] : tree.at_center[c].uncertified) pairs.push_back({a, b, test.leaves_touch(a, b)});
    radius.push_back(tree.at_center[c].radius);
  }
  radii = std::move(tree.radii);
  never_certified = std::move(tree.never_certified);
}

Result<ReducedShape> ReducedShape::build(std::shared_ptr<const ReducedMotion> motion,
                                         std::vector<ReducedCenter> centers, const ReducedSettings& settings,
                                         const ReducedHooks& hooks) {
  const PlainArithmetic plain;
  if (!(settings.clearance >= 0) || !std::isfinite(settings.clearance))
    return fail(ErrorCode::InvalidArgument, "clearance", "is not a length", "give a number of at least 0");
  std::vector<CenterPose> poses;
  const auto impl = FOLDPROOF_TRY(start_shape(std::move(motion), std::move(centers), poses));
  const double clearance = settings.clearance > 0 ? settings.clearance : size_of(poses[0]) * 0x1p-24;
  const std::shared_ptr<const Hierarchy>& hierarchy = impl->motion->hierarchy();
  const PatchSlots slots(hierarchy);
  const BallInput input{*impl->motion, *impl->nodes, slots, poses, clearance, settings.max_triangles};
  const std::size_t budget = 64 + std::size_t{settings.pairs_per_leaf} * hierarchy->leaf_count();
  impl->use(FOLDPROOF_TRY(build_balls(input, impl->centers, budget, hooks)), poses);
  ReducedShape shape;
  shape.impl_ = impl;
  return shape;
}

Result<ReducedShape> ReducedShape::from_balls(std::shared_ptr<const ReducedMotion> motion,
                                              std::vector<ReducedCenter> centers, ReducedBalls balls) {
  const PlainArithmetic plain;
  std::vector<CenterPose> poses;
  const auto impl = FOLDPROOF_TRY(start_shape(std::move(motion), std::move(centers), poses));
  if (!are_balls_of(*impl->motion->hierarchy(), impl->centers.size(), balls))
    return fail(ErrorCode::InvalidArgument, "balls", "are not of this hierarchy and these centers",
                "prove them again");
  impl->use(std::move(balls), poses);
  ReducedShape shape;
  shape.impl_ = impl;
  return shape;
}

const ReducedBalls& ReducedShape::balls() const { return impl_->balls; }
const std::shared_ptr<const ReducedMotion>& ReducedShape::motion() const { return impl_->motion; }
std::span<const ReducedCenter> ReducedShape::centers() const { return impl_->centers; }
double ReducedShape::clearance() const { return impl_->balls.clearance; }
double ReducedShape::radius(Index center) const { return impl_->radius[center]; }
std::span<const UncertifiedPair> ReducedShape::uncertified(Index center) const {
  return impl_->uncertified[center];
}
std::span<const std::array<Index, 2>> ReducedShape::never_certified() const { return impl_->never_certified; }

// A ball in the tree is the larger of the pair's own and the smallest below it. Without some pairs the
// smallest below may be larger. The larger of this one and the ball in the tree is again a ball.
CertifiedRadius ReducedShape::certified(Index center, double at_least) const {
  const auto& pairs = impl_->balls.pairs;
  const std::size_t width = impl_->centers.size();
  const auto nodes = impl_->motion->hierarchy()->nodes();
  CertifiedRadius result{0, impl_->uncertified[center]};
  std::vector<float> radius(pairs.size());
  for (std::size_t i = pairs.size(); i-- > 0;) {
    const ReducedBalls::Pair& node = pairs[i];
    radius[i] = impl_->radii[i * width + center];
    if (node.count > 0) {
      const auto children = radius.begin() + node.begin;
      radius[i] = std::max(radius[i], *std::min_element(children, children + node.count));
    } else if (nodes[node.a].is_leaf() && nodes[node.b].is_leaf() &&
               (radius[i] < at_least || radius[i] == 0)) {
      const auto [a, b] = std::minmax(nodes[node.a].leaf_begin, nodes[node.b].leaf_begin);
      if (radius[i] > 0) result.uncertified.push_back({a, b, false, radius[i]});
      radius[i] = std::numeric_limits<float>::infinity();
    }
  }
  std::sort(result.uncertified.begin(), result.uncertified.end(),
            [](const UncertifiedPair& x, const UncertifiedPair& y) {
              return std::tuple(x.leaf_a, x.leaf_b) < std::tuple(y.leaf_a, y.leaf_b);
            });
  result.radius = std::min(double{radius[0]}, impl_->centers[center].max_radius);
  return result;
}

// Each term has a few roundings, the sum one per mode; the margin is far above them.
float ReducedShape::Impl::distance(Index center, std::span<const double> p) const {
  const std::vector<double>& c = centers[center].p;
  double square = 0, largest = 0;
  for (std::size_t k = 0; k < c.size(); ++k) {
    const double q = (p[k] - c[k]) * inverse_deviations[k];
    square += q * q;
    largest = std::max(largest, std::abs(q));
  }
  const double norm = std::max(std::sqrt(square), largest) * (1 + kSumError);  // squares may underflow
  return norm < 1e30 ? round_up(norm) : std::numeric_limits<float>::infinity();
}

double ReducedShape::distance(Index center, std::span<const double> p) const {
  const PlainArithmetic plain;
  return double{impl_->distance(center, p)};
}

// The regularized incomplete gamma function P(modes / 2, radius^2 / 2) by its series, whose terms are all
// positive (Abramowitz and Stegun 6.5.29).
double normal_share(double radius, Index modes) {
  const double a = modes / 2.0, x = radius * radius / 2;
  if (!(x > 0)) return 0;
  if (x > 2 * a + 200) return 1;
  double term = 1, sum = 1;
  for (int n = 1; term > sum * 1e-17; ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return std::min(1.0, sum * std::exp(a * std::log(x) - x - std::lgamma(a + 1)));
}

namespace {

// The two centers nearest to a step, and their distances from its farther end.
struct Nearest {
  std::array<Index, 2> center{0, 0};
  std::array<float, 2> distance{std::numeric_limits<float>::infinity(),
                                std::numeric_limits<float>::infinity()};
};

Nearest nearest_centers(const ReducedShape::Impl& shape, std::span<const double> p0,
                        std::span<const double> p1) {
  Nearest nearest;
  for (Index c = 0; c < shape.centers.size(); ++c) {
    const float distance = std::max(shape.distance(c, p0), shape.distance(c, p1));
    if (distance < nearest.distance[0]) {
      nearest.center[1] = std::exchange(nearest.center[0], c);
      nearest.distance[1] = std::exchange(nearest.distance[0], distance);
    } else if (distance < nearest.distance[1]) {
      nearest.center[1] = c;
      nearest.distance[1] = distance;
    }
  }
  return nearest;
}

}  // namespace

ReducedProof ReducedShape::proven_free(std::span<const double> p0, std::span<const double> p1,
                                       Scratch& scratch) const {
  const PlainArithmetic plain;
  return impl_->find_unproven(p0, p1, 0, scratch);
}

ReducedProof ReducedShape::find_unproven(std::span<const double> p0, std::span<const double> p1,
                                         Scratch& scratch) const {
  const PlainArithmetic plain;
  return impl_->find_unproven(p0, p1, impl_->balls.pairs.size(), scratch);
}

ReducedProof ReducedShape::Impl::find_unproven(std::span<const double> p0, std::span<const double> p1,
                                               std::size_t max_unproven, Scratch& scratch) const {
  scratch.unproven.clear();
  scratch.visited = scratch.proven = 0;
  const std::size_t modes = inverse_deviations.size(), width = centers.size();
  const ReducedProof free =
      never_certified.empty() ? ReducedProof::Free : ReducedProof::FreeExceptUncertified;
  Nearest nearest;
  // R5: the clearance covers the rounding of two points, sqrt(3) each.
  if (p0.size() == modes && p1.size() == modes &&
      4 * std::max(motion->rounding(p0), motion->rounding(p1)) <= balls.clearance)
    nearest = nearest_centers(*this, p0, p1);
  if (!(nearest.distance[0] < std::numeric_limits<float>::infinity())) {
    scratch.unproven.push_back({0, 0});
    return ReducedProof::Unproven;
  }
  // Eq. 8, for the two nearest centers.
  const auto is_free = [&](Index pair) {
    ++scratch.visited;
    const float* own = &radii[pair * width];
    const bool inside =
        nearest.distance[0] < own[nearest.center[0]] || nearest.distance[1] < own[nearest.center[1]];
    scratch.proven += inside;
    return inside;
  };
  if (is_free(0)) return free;
  scratch.stack.assign(1, 0);
  while (!scratch.stack.empty()) {
    const ReducedBalls::Pair& node = balls.pairs[scratch.stack.back()];
    scratch.stack.pop_back();
    if (node.count == 0) {
      scratch.unproven.push_back({node.a, node.b});
      if (scratch.unproven.size() > max_unproven) return ReducedProof::Unproven;
    }
    for (Index child = node.begin; child < node.begin + node.count; ++child) {
      if (!is_free(child)) scratch.stack.push_back(child);
    }
  }
  return scratch.unproven.empty() ? free : ReducedProof::Unproven;
}

}  // namespace foldproof
