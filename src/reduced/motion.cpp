#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "base/try.h"
#include "bvh/kinetic_bvh.h"
#include "foldproof/reduced.h"

namespace foldproof {
namespace {

constexpr Index kMaxModes = 1024;

Result<void> check_subspace(const Hierarchy& hierarchy, const Pca& subspace) {
  const auto expected = 3 * static_cast<Eigen::Index>(hierarchy.topology().vertex_count());
  if (subspace.mean.size() != expected || subspace.basis.rows() != expected) {
    return fail(ErrorCode::InvalidArgument, "subspace",
                fmt::format("has {} numbers per shape, but the mesh {}", subspace.mean.size(), expected),
                "use the subspace of this mesh");
  }
  if (subspace.modes() < 1 || subspace.modes() > kMaxModes)
    return fail(ErrorCode::InvalidArgument, "subspace", fmt::format("has {} modes", subspace.modes()),
                fmt::format("keep 1 to {}", kMaxModes));
  if (subspace.deviations.size() != subspace.basis.cols())
    return fail(ErrorCode::InvalidArgument, "subspace", "does not have one deviation per mode",
                "build it again");
  // The basis is stored in single precision.
  const double limit = std::numeric_limits<float>::max();
  const bool finite = subspace.mean.allFinite() && subspace.basis.allFinite() &&
                      subspace.deviations.allFinite() && subspace.basis.cwiseAbs().maxCoeff() < limit;
  if (!finite || !(subspace.deviations.minCoeff() > 0))
    return fail(ErrorCode::NonFinite, "subspace",
                "has numbers that are not finite, or deviations that are not positive", "build it again");
  return {};
}

}  // namespace

Result<ReducedMotion> ReducedMotion::make(std::shared_ptr<const Hierarchy> hierarchy, const Pca& subspace) {
  FOLDPROOF_TRY(check_subspace(*hierarchy, subspace));
  ReducedMotion motion;
  const Index count = hierarchy->topology().vertex_count(), modes = subspace.modes();
  motion.modes_ = modes;
  motion.ids_.assign(hierarchy->vertex_ids().begin(), hierarchy->vertex_ids().end());
  std::vector<bool> used(count, false);
  for (const Index id : motion.ids_) used[id] = true;
  for (Index id = 0; id < count; ++id) {
    if (!used[id]) motion.ids_.push_back(id);
  }
  motion.mean_.resize(3 * std::size_t{count});
  motion.basis_.resize(3 * std::size_t{count} * modes);
  motion.max_basis_.assign(modes, 0);
  for (std::size_t v = 0; v < count; ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Index from = 3 * Eigen::Index{motion.ids_[v]} + axis;
      motion.mean_[3 * v + axis] = subspace.mean[from];
      motion.max_mean_ = std::max(motion.max_mean_, std::abs(subspace.mean[from]));
      for (Index k = 0; k < modes; ++k) {
        const auto value = static_cast<float>(subspace.basis(from, k));
        motion.basis_[(v * modes + k) * 3 + axis] = value;
        motion.max_basis_[k] = std::max(motion.max_basis_[k], std::abs(double{value}));
      }
    }
  }
  motion.deviations_.assign(subspace.deviations.data(), subspace.deviations.data() + modes);
  motion.hierarchy_ = std::move(hierarchy);
  LeafVertexLists lists = list_leaf_vertices(*motion.hierarchy_);
  motion.leaf_begin_ = std::move(lists.begin);
  motion.leaf_vertices_ = std::move(lists.vertices);
  return motion;
}

void ReducedMotion::positions(std::span<const double> p, std::span<double> out) const {
  parallel_for(IndexRange{0, ids_.size()}, 1024, [&](IndexRange range) {
    for (std::size_t v = range.begin; v < range.end; ++v) {
      double x[3];
      vertex(static_cast<Index>(v), p, x);
      std::copy(x, x + 3, &out[3 * std::size_t{ids_[v]}]);
    }
  });
}

double ReducedMotion::max_coordinate(std::span<const double> p) const {
  const PlainArithmetic plain;
  double size = max_mean_;
  for (Index k = 0; k < modes_; ++k) size += max_basis_[k] * std::abs(p[k]);
  return size * (1 + 0x1p-40);
}

// docs/soundness.md, R5: one rounding per product and per sum, each relative to a sum of magnitudes.
double ReducedMotion::rounding_at(double max_coordinate) const {
  return max_coordinate * (modes_ + 2) * 0x1p-52;
}

}  // namespace foldproof
