#include "reduced/shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/plain_arithmetic.h"
#include "reduced/touch_test.h"

namespace foldproof {
namespace {

Result<void> check_centres(const ReducedMotion& motion, std::vector<ReducedCentre>& centres) {
  if (centres.empty()) return fail("centres", "there are none", "give at least one, such as the mean");
  for (std::size_t c = 0; c < centres.size(); ++c) {
    const auto where = fmt::format("centre {}", c);
    if (centres[c].p.size() != motion.modes()) {
      return fail(where, fmt::format("has {} numbers", centres[c].p.size()),
                  fmt::format("give {}, one per mode", motion.modes()));
    }
    for (const double p : centres[c].p) {
      if (!std::isfinite(p)) return fail(where, "has a number that is not finite", "repair it");
    }
    if (!(centres[c].reach >= 0) || !std::isfinite(centres[c].reach))
      return fail(where, "has a reach that is no distance", "give a number of at least 0");
    if (centres[c].reach == 0) centres[c].reach = std::sqrt(motion.modes()) + 4.0;
  }
  return {};
}

double size_of(const CentrePose& pose) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = 0; i < pose.x.size(); i += 3) {
    const Eigen::Map<const Vec3> x(&pose.x[i]);
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).maxCoeff();
}

}  // namespace

Result<ReducedShape> ReducedShape::build(std::shared_ptr<const ReducedMotion> motion,
                                         std::vector<ReducedCentre> centres, const ReducedSettings& settings,
                                         const ReducedHooks& hooks) {
  const PlainArithmetic plain;
  if (const auto ok = check_centres(*motion, centres); !ok) return tl::unexpected(ok.error());
  if (!(settings.clearance >= 0) || !std::isfinite(settings.clearance))
    return fail("clearance", "is not a length", "give a number of at least 0");
  auto impl = std::make_shared<Impl>();
  const std::shared_ptr<const Hierarchy>& hierarchy = motion->hierarchy();
  std::vector<CentrePose> poses;
  poses.reserve(centres.size());
  for (const ReducedCentre& centre : centres) poses.emplace_back(*motion, centre.p);
  impl->clearance = settings.clearance > 0 ? settings.clearance : size_of(poses[0]) * 0x1p-24;
  impl->nodes = std::make_shared<const NodeMotions>(*motion, poses);
  for (const double deviation : motion->deviations()) impl->stiffness.push_back(1 / deviation);
  const PatchSlots slots(hierarchy);
  const BallInput input{*motion, *impl->nodes, slots, poses, impl->clearance, settings.most_triangles};
  const std::size_t budget = 64 + std::size_t{settings.pairs_per_leaf} * hierarchy->leaf_count();
  auto grown = grow_pair_tree(input, centres, budget, hooks);
  if (!grown) return tl::unexpected(grown.error());
  for (std::size_t c = 0; c < centres.size(); ++c) {
    const auto& of_centre = grown->of_centre[c];
    const TouchTest test(*hierarchy, poses[c]);
    auto& left_out = impl->left_out.emplace_back();
    for (const auto& [a, b] : of_centre.left_out) left_out.push_back({a, b, test.leaves_touch(a, b)});
    impl->radius.push_back(of_centre.radius);
  }
  impl->tree = std::move(grown->tree);
  impl->always_open = std::move(grown->always_open);
  impl->centres = std::move(centres);
  impl->motion = std::move(motion);
  ReducedShape shape;
  shape.impl_ = std::move(impl);
  return shape;
}

const std::shared_ptr<const ReducedMotion>& ReducedShape::motion() const { return impl_->motion; }
std::span<const ReducedCentre> ReducedShape::centres() const { return impl_->centres; }
double ReducedShape::clearance() const { return impl_->clearance; }
double ReducedShape::radius(Index centre) const { return impl_->radius[centre]; }
std::span<const LeftOut> ReducedShape::left_out(Index centre) const { return impl_->left_out[centre]; }
std::span<const std::array<Index, 2>> ReducedShape::always_open() const { return impl_->always_open; }

// A ball in the tree is the larger of the pair's own and the smallest below it. Taking pairs out makes the
// smallest below larger, and the larger of that and what stood there is again a ball.
CertifiedRadius ReducedShape::certified(Index centre, double at_least) const {
  const PairTree& tree = impl_->tree;
  const auto nodes = impl_->motion->hierarchy()->nodes();
  CertifiedRadius result{0, impl_->left_out[centre]};
  std::vector<float> radius(tree.nodes.size());
  for (std::size_t i = tree.nodes.size(); i-- > 0;) {
    const PairTree::Node& node = tree.nodes[i];
    radius[i] = tree.balls[i * tree.centres + centre];
    if (node.count > 0) {
      const auto below = radius.begin() + node.begin;
      radius[i] = std::max(radius[i], *std::min_element(below, below + node.count));
    } else if (nodes[node.a].is_leaf() && nodes[node.b].is_leaf() &&
               (radius[i] < at_least || radius[i] == 0)) {
      const auto [a, b] = std::minmax(nodes[node.a].leaf_begin, nodes[node.b].leaf_begin);
      if (radius[i] > 0) result.left_out.push_back({a, b, false, radius[i]});
      radius[i] = std::numeric_limits<float>::infinity();
    }
  }
  std::sort(result.left_out.begin(), result.left_out.end(), [](const LeftOut& x, const LeftOut& y) {
    return std::tuple(x.leaf_a, x.leaf_b) < std::tuple(y.leaf_a, y.leaf_b);
  });
  result.radius = std::min(double{radius[0]}, impl_->centres[centre].reach);
  return result;
}

// Each term carries a few roundings, the sum one per mode; the margin is far above them.
float ReducedShape::Impl::distance(Index centre, std::span<const double> p) const {
  const std::vector<double>& c = centres[centre].p;
  double square = 0;
  for (std::size_t k = 0; k < c.size(); ++k) {
    const double q = (p[k] - c[k]) * stiffness[k];
    square += q * q;
  }
  const double norm = std::sqrt(square) * (1 + kSumError);
  return norm < 1e30 ? round_up(norm) : std::numeric_limits<float>::infinity();
}

double ReducedShape::distance(Index centre, std::span<const double> p) const {
  const PlainArithmetic plain;
  return double{impl_->distance(centre, p)};
}

// The regularised incomplete gamma function P(modes / 2, radius^2 / 2) by its series, whose terms are all
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

// The two centres that hold both ends nearest, and how near.
struct Nearest {
  std::array<Index, 2> centre{0, 0};
  std::array<float, 2> distance{std::numeric_limits<float>::infinity(),
                                std::numeric_limits<float>::infinity()};
};

Nearest nearest_centres(const ReducedShape::Impl& shape, std::span<const double> p0,
                        std::span<const double> p1) {
  Nearest nearest;
  for (Index c = 0; c < shape.centres.size(); ++c) {
    const float far = std::max(shape.distance(c, p0), shape.distance(c, p1));
    if (far < nearest.distance[0]) {
      nearest.centre[1] = std::exchange(nearest.centre[0], c);
      nearest.distance[1] = std::exchange(nearest.distance[0], far);
    } else if (far < nearest.distance[1]) {
      nearest.centre[1] = c;
      nearest.distance[1] = far;
    }
  }
  return nearest;
}

}  // namespace

ReducedProof ReducedShape::proven_free(std::span<const double> p0, std::span<const double> p1,
                                       Scratch& scratch) const {
  const PlainArithmetic plain;
  return impl_->find_open(p0, p1, 0, scratch);
}

ReducedProof ReducedShape::find_open(std::span<const double> p0, std::span<const double> p1,
                                     Scratch& scratch) const {
  const PlainArithmetic plain;
  return impl_->find_open(p0, p1, impl_->tree.nodes.size(), scratch);
}

ReducedProof ReducedShape::Impl::find_open(std::span<const double> p0, std::span<const double> p1,
                                           std::size_t most, Scratch& scratch) const {
  scratch.open.clear();
  scratch.visits = scratch.proven = 0;
  const std::size_t modes = stiffness.size(), width = tree.centres;
  const ReducedProof best = always_open.empty() ? ReducedProof::Free : ReducedProof::FreeButLeft;
  Nearest nearest;
  if (p0.size() == modes && p1.size() == modes) nearest = nearest_centres(*this, p0, p1);
  if (!(nearest.distance[0] < std::numeric_limits<float>::infinity())) {
    scratch.open.push_back({0, 0});
    return ReducedProof::Open;
  }
  // Eq. 8, for the two nearest centres.
  const auto is_free = [&](Index pair) {
    ++scratch.visits;
    const float* balls = &tree.balls[pair * width];
    const bool free =
        nearest.distance[0] < balls[nearest.centre[0]] || nearest.distance[1] < balls[nearest.centre[1]];
    scratch.proven += free;
    return free;
  };
  if (is_free(0)) return best;
  scratch.stack.assign(1, 0);
  while (!scratch.stack.empty()) {
    const PairTree::Node& node = tree.nodes[scratch.stack.back()];
    scratch.stack.pop_back();
    if (node.count == 0) {
      scratch.open.push_back({node.a, node.b});
      if (scratch.open.size() > most) return ReducedProof::Open;
    }
    for (Index child = node.begin; child < node.begin + node.count; ++child) {
      if (!is_free(child)) scratch.stack.push_back(child);
    }
  }
  return scratch.open.empty() ? best : ReducedProof::Open;
}

}  // namespace foldproof
