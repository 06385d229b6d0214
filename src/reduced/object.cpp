#include "reduced/object.h"

#include <fmt/format.h>

#include <cmath>

#include "base/plain_arithmetic.h"
#include "base/try.h"
#include "foldproof/eigen.h"

namespace foldproof {
namespace {

// How far a matrix may be from orthogonal. Rotations in single precision are closer.
constexpr double kOrthogonalTolerance = 1e-6;

Vec3 apply(const ReducedPose& pose, const Vec3& x) {
  Vec3 y;
  for (int i = 0; i < 3; ++i) {
    y[i] = ((pose.rotation(i, 0) * x[0] + pose.rotation(i, 1) * x[1]) + pose.rotation(i, 2) * x[2]) +
           pose.translation[i];
  }
  return y;
}

}  // namespace

void pose_vertices(const ReducedMotion& motion, const ReducedPose& pose, std::span<double> out) {
  const PlainArithmetic plain;
  motion.positions(pose.p, out);
  for (std::size_t i = 0; i < out.size(); i += 3) {
    apply(pose, Vec3::load(&out[i])).store(&out[i]);
  }
}

bool internal::boxes_separated(const ReducedBox& a, const ReducedBox& b, double distance) {
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

Result<double> ReducedObject::check_pose(Index object, const ReducedPose& pose) const {
  const auto where = [&] { return fmt::format("object {}", object); };
  const Index modes = shape_->motion()->modes();
  if (pose.p.size() != modes)
    return fail(ErrorCode::InvalidArgument, where(), fmt::format("has {} coordinates", pose.p.size()),
                fmt::format("give {}, one per mode", modes));
  for (const double p : pose.p) {
    if (!std::isfinite(p))
      return fail(ErrorCode::NonFinite, where(), "has a coordinate that is not finite", "repair it");
  }
  // A maximum may pass over NaN.
  const Eigen::Matrix3d square = pose.rotation.transpose() * pose.rotation;
  if (!pose.translation.allFinite() || !pose.rotation.allFinite() ||
      !(((square - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff()) < kOrthogonalTolerance))
    return fail(ErrorCode::InvalidArgument, where(),
                "has a matrix that is no rotation, or a translation that is not finite",
                "give an orthogonal matrix and finite numbers");
  const double max_coordinate = shape_->motion()->max_coordinate(pose.p);
  if (!std::isfinite(max_coordinate))
    return fail(ErrorCode::LimitExceeded, where(), "has coordinates that are too large", "make them smaller");
  return max_coordinate;
}

Result<void> ReducedObject::start_step(Index object, const ReducedPose& start, const ReducedPose& end) {
  poses_[0] = start;
  poses_[1] = end;
  if (++step_ == 0) {  // the counter has wrapped around: earlier marks are void
    for (auto* marks : {&box_step_, &vertex_step_, &leaf_step_, &features_step_})
      std::fill(marks->begin(), marks->end(), 0u);
    all_step_ = 0;
    step_ = 1;
  }
  const ReducedMotion& motion = *shape_->motion();
  for (int e = 0; e < 2; ++e) {
    const double max_coordinate = FOLDPROOF_TRY(check_pose(object, poses_[e]));
    // R5: of x(p), then of three products and sums.
    rounding_[e] = 2 * motion.rounding_at(max_coordinate) +
                   0x1p-50 * (2 * max_coordinate + poses_[e].translation.cwiseAbs().maxCoeff());
    distance_[e] = std::numeric_limits<double>::infinity();
    for (Index c = 0; c < shape_->centers().size(); ++c) {
      const double d = shape_->distance(c, poses_[e].p);
      if (d < distance_[e]) {
        distance_[e] = d;
        nearest_[e] = c;
      }
    }
    if (!std::isfinite(distance_[e]))
      return fail(ErrorCode::LimitExceeded, fmt::format("object {}", object), "is too far from every center",
                  "make its coordinates smaller");
  }
  return {};
}

void ReducedObject::bound_by_p(Index node, ReducedBox& box) const {
  const NodeMotions& nodes = *shape_->impl().nodes;
  for (int e = 0; e < 2; ++e) {
    const Vec3 middle = apply(poses_[e], nodes.at(node, poses_[e].p));
    const auto& extent = nodes.at_center[nearest_[e]][node].extent;
    const auto& growth = nodes.points[node].growth;
    Vec3 half;
    for (int axis = 0; axis < 3; ++axis)
      half[axis] = double{extent[axis]} + distance_[e] * double{growth[axis]};
    half = to_vec3(poses_[e].rotation.cwiseAbs() * to_eigen(half) * (1 + kSumError) +
                   Eigen::Vector3d::Constant(2 * rounding_[e]));
    box.low[e] = middle - half;
    box.high[e] = middle + half;
  }
}

// No rounding to allow for: the narrow phase reads the same vertices.
void ReducedObject::fit_leaf(Index leaf, ReducedBox& box) const {
  const ReducedMotion& motion = *shape_->motion();
  for (int e = 0; e < 2; ++e) {
    box.low[e] = Vec3::Constant(std::numeric_limits<double>::infinity());
    box.high[e] = -box.low[e];
    for (const Index v : motion.leaf_vertices(leaf)) {
      const Vec3 x = Vec3::load(&x_[e][3 * std::size_t{motion.hierarchy()->vertex_ids()[v]}]);
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
    bound_by_p(node, box);
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

// R6. A matrix changes lengths by no more than it deviates from orthogonal.
bool ReducedObject::balls_apply(double distance) const {
  if (poses_[0].rotation != poses_[1].rotation) return false;
  const double rounding = 4 * std::max(rounding_[0], rounding_[1]);  // of two points, sqrt(3) each
  return distance + rounding <= shape_->clearance() * (1 - 4 * kOrthogonalTolerance);
}

void ReducedObject::compute_leaf(const Frame& frame, LeafIndex leaf, KineticBvh& bvh) {
  if (leaf_step_[leaf] == step_) return;
  leaf_step_[leaf] = step_;
  const ReducedMotion& motion = *shape_->motion();
  const bool known = all_step_ == step_;
  if (!known) all_p_.clear();
  for (const Index v : motion.leaf_vertices(leaf)) {
    if (vertex_step_[v] == step_) continue;
    vertex_step_[v] = step_;
    const std::size_t at = 3 * std::size_t{motion.hierarchy()->vertex_ids()[v]};
    for (int e = 0; e < 2 && !known; ++e) {
      double x[3];
      motion.vertex(v, poses_[e].p, x);
      apply(poses_[e], Vec3::load(x)).store(&x_[e][at]);
    }
    bvh.set_vertex(frame, v, &x_[0][at], &x_[1][at]);
  }
  const NodeIndex node = bvh.leaf_node(leaf);
  fit_leaf(leaf, boxes_[node]);
  box_step_[node] = step_;
}

void ReducedObject::compute_features(LeafIndex leaf, KineticBvh& bvh) {
  if (features_step_[leaf] == step_) return;
  features_step_[leaf] = step_;
  bvh.refit_leaf(leaf);
  bvh.fill_features(leaf);
}

// A step that starts where the last one ended takes over the vertices.
void ReducedObject::compute_all() {
  if (all_step_ == step_) return;
  all_step_ = step_;
  std::fill(box_step_.begin(), box_step_.end(), 0u);
  if (std::equal(all_p_.begin(), all_p_.end(), poses_[0].p.begin(), poses_[0].p.end()) &&
      all_pose_.rotation == poses_[0].rotation && all_pose_.translation == poses_[0].translation) {
    std::swap(x_[0], x_[1]);
  } else {
    pose_vertices(*shape_->motion(), poses_[0], x_[0]);
  }
  pose_vertices(*shape_->motion(), poses_[1], x_[1]);
  all_pose_ = poses_[1];
  all_p_.assign(poses_[1].p.begin(), poses_[1].p.end());
}

}  // namespace foldproof
