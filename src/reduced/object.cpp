#include "reduced/object.h"

#include <fmt/format.h>

#include <cmath>

#include "base/plain_arithmetic.h"

namespace foldproof {
namespace {

// Rotations may be this far from orthogonal, as those of single precision nearly are not.
constexpr double kLeastOrthogonal = 1e-6;

Vec3 placed(const ReducedPose& pose, const Vec3& x) {
  Vec3 y;
  for (int i = 0; i < 3; ++i) {
    y[i] = ((pose.rotation(i, 0) * x[0] + pose.rotation(i, 1) * x[1]) + pose.rotation(i, 2) * x[2]) +
           pose.translation[i];
  }
  return y;
}

}  // namespace

void place_vertices(const ReducedMotion& motion, const ReducedPose& pose, std::span<double> out) {
  const PlainArithmetic plain;
  motion.positions(pose.p, out);
  for (std::size_t i = 0; i < out.size(); i += 3) {
    Eigen::Map<Vec3> x(&out[i]);
    x = placed(pose, Vec3(x));
  }
}

bool boxes_apart(const ReducedBox& a, const ReducedBox& b, double distance) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto gap = [&](const ReducedBox& below, const ReducedBox& above, int end) {
      return above.low[end][axis] - below.high[end][axis];
    };
    if (gap(a, b, 0) > distance && gap(a, b, 1) > distance) return true;
    if (gap(b, a, 0) > distance && gap(b, a, 1) > distance) return true;
  }
  return false;
}

ReducedObject::ReducedObject(std::shared_ptr<const ReducedShape> shape) : shape_(std::move(shape)) {
  const Hierarchy& h = *shape_->motion()->hierarchy();
  for (auto& x : x_) x.resize(3 * std::size_t{h.topology().vertex_count()});
  box_step_.resize(h.nodes().size(), 0);
  boxes_.resize(h.nodes().size());
  vertex_step_.resize(h.vertex_ids().size(), 0);
  leaf_step_.resize(h.leaf_count(), 0);
  features_step_.resize(h.leaf_count(), 0);
  all_p_.reserve(shape_->motion()->modes());
}

Result<void> ReducedObject::check_pose(Index object, const ReducedPose& pose, double& reach) const {
  const auto where = [&] { return fmt::format("object {}", object); };
  const Index modes = shape_->motion()->modes();
  if (pose.p.size() != modes)
    return fail(where(), fmt::format("has {} coordinates", pose.p.size()),
                fmt::format("give {}, one per mode", modes));
  for (const double p : pose.p) {
    if (!std::isfinite(p)) return fail(where(), "has a coordinate that is not finite", "repair it");
  }
  reach = shape_->motion()->reach(pose.p);
  const Eigen::Matrix3d square = pose.rotation.transpose() * pose.rotation;
  if (!pose.translation.allFinite() ||
      !(((square - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff()) < kLeastOrthogonal))
    return fail(where(), "has a placement that is no rotation and translation", "give an orthogonal matrix");
  if (!std::isfinite(reach)) return fail(where(), "has coordinates that are too large", "make them smaller");
  return {};
}

Result<void> ReducedObject::begin_step(Index object, const ReducedPose& begin, const ReducedPose& end) {
  poses_[0] = begin;  // one by one, so that their memory is kept
  poses_[1] = end;
  if (++step_ == 0) {  // the counter went round: what it marked is of old
    for (auto* marks : {&box_step_, &vertex_step_, &leaf_step_, &features_step_})
      std::fill(marks->begin(), marks->end(), 0u);
    all_step_ = 0;
    step_ = 1;
  }
  const ReducedMotion& motion = *shape_->motion();
  for (int e = 0; e < 2; ++e) {
    double reach = 0;
    if (auto ok = check_pose(object, poses_[e], reach); !ok) return ok;
    // R5: x(p), and three products and sums on it.
    rounding_[e] =
        2 * motion.rounding_at(reach) + 0x1p-50 * (2 * reach + poses_[e].translation.cwiseAbs().maxCoeff());
    distance_[e] = std::numeric_limits<double>::infinity();
    for (Index c = 0; c < shape_->centres().size(); ++c) {
      const double d = shape_->distance(c, poses_[e].p);
      if (d < distance_[e]) {
        distance_[e] = d;
        nearest_[e] = c;
      }
    }
    if (!std::isfinite(distance_[e]))
      return fail(fmt::format("object {}", object), "is too far from every centre",
                  "make its coordinates smaller");
  }
  return {};
}

void ReducedObject::reach_from_p(Index node, ReducedBox& box) const {
  const NodeMotions& nodes = *shape_->impl().nodes;
  for (int e = 0; e < 2; ++e) {
    const Vec3 middle = placed(poses_[e], nodes.at(node, poses_[e].p));
    const auto& extent = nodes.around[nearest_[e]][node].extent;
    const auto& grow = nodes.points[node].grow;
    Vec3 half;
    for (int axis = 0; axis < 3; ++axis)
      half[axis] = double{extent[axis]} + distance_[e] * double{grow[axis]};
    half = poses_[e].rotation.cwiseAbs() * half * (1 + kSumError) + Vec3::Constant(2 * rounding_[e]);
    box.low[e] = middle - half;
    box.high[e] = middle + half;
  }
}

// The vertices are those that the narrow phase reads: there is no rounding to allow for.
void ReducedObject::fit_leaf(Index leaf, ReducedBox& box) const {
  const ReducedMotion& motion = *shape_->motion();
  for (int e = 0; e < 2; ++e) {
    box.low[e].setConstant(std::numeric_limits<double>::infinity());
    box.high[e] = -box.low[e];
    for (const Index place : motion.leaf_vertices(leaf)) {
      const Eigen::Map<const Vec3> x(&x_[e][3 * std::size_t{motion.hierarchy()->vertex_ids()[place]}]);
      box.low[e] = box.low[e].cwiseMin(x);
      box.high[e] = box.high[e].cwiseMax(x);
    }
  }
}

const ReducedBox& ReducedObject::box(Index node) {
  ReducedBox& box = boxes_[node];
  if (box_step_[node] == step_) return box;
  box_step_[node] = step_;
  const Hierarchy::Node& n = shape_->motion()->hierarchy()->nodes()[node];
  if (all_step_ != step_) {
    reach_from_p(node, box);
  } else if (n.is_leaf()) {
    fit_leaf(n.leaf_begin, box);
  } else {
    const ReducedBox &left = this->box(node + 1), &right = this->box(n.right);
    for (int e = 0; e < 2; ++e) {
      box.low[e] = left.low[e].cwiseMin(right.low[e]);
      box.high[e] = left.high[e].cwiseMax(right.high[e]);
    }
  }
  return box;
}

// R6. Lengths change with a rotation by no more than it is short of orthogonal.
bool ReducedObject::balls_hold(double distance) const {
  if (poses_[0].rotation != poses_[1].rotation) return false;
  const double off = 4 * std::max(rounding_[0], rounding_[1]);  // two points, sqrt(3) each
  return distance + off <= shape_->clearance() * (1 - 4 * kLeastOrthogonal);
}

void ReducedObject::need_leaf(const Frame& frame, Index leaf, KineticTree& tree) {
  if (leaf_step_[leaf] == step_) return;
  leaf_step_[leaf] = step_;
  const ReducedMotion& motion = *shape_->motion();
  const bool known = all_step_ == step_;
  if (!known) all_p_.clear();
  for (const Index place : motion.leaf_vertices(leaf)) {
    if (vertex_step_[place] == step_) continue;
    vertex_step_[place] = step_;
    const std::size_t at = 3 * std::size_t{motion.hierarchy()->vertex_ids()[place]};
    for (int e = 0; e < 2 && !known; ++e) {
      double x[3];
      motion.vertex(place, poses_[e].p, x);
      Eigen::Map<Vec3> world(&x_[e][at]);
      world = placed(poses_[e], Vec3(x[0], x[1], x[2]));
    }
    tree.move_vertex(frame, place, &x_[0][at], &x_[1][at]);
  }
  const Index node = tree.leaf_node(leaf);
  fit_leaf(leaf, boxes_[node]);
  box_step_[node] = step_;
}

void ReducedObject::need_features(Index leaf, KineticTree& tree) {
  if (features_step_[leaf] == step_) return;
  features_step_[leaf] = step_;
  tree.fit_leaf(leaf);
  tree.fill_features(leaf);
}

// A step that begins where the last one ended takes its vertices from there.
void ReducedObject::need_all() {
  if (all_step_ == step_) return;
  all_step_ = step_;
  std::fill(box_step_.begin(), box_step_.end(), 0u);
  if (std::equal(all_p_.begin(), all_p_.end(), poses_[0].p.begin(), poses_[0].p.end()) &&
      all_pose_.rotation == poses_[0].rotation && all_pose_.translation == poses_[0].translation) {
    std::swap(x_[0], x_[1]);
  } else {
    place_vertices(*shape_->motion(), poses_[0], x_[0]);
  }
  place_vertices(*shape_->motion(), poses_[1], x_[1]);
  all_pose_ = poses_[1];
  all_p_.assign(poses_[1].p.begin(), poses_[1].p.end());
}

}  // namespace foldproof
