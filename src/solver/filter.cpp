#include <fmt/format.h>

#include <algorithm>

#include "foldproof/solver.h"

namespace foldproof {
namespace {

constexpr Index kMaxGroups = 10000;

}  // namespace

struct CollisionFilter::Groups {
  std::vector<Index> of_vertex;
  Index count = 0;
  std::vector<bool> excluded;  // count x count
  bool allows(Index i, Index j) const { return !excluded[std::size_t{of_vertex[i]} * count + of_vertex[j]]; }
};

CollisionFilter::CollisionFilter(std::function<bool(Index, Index)> can_collide) {
  if (can_collide)
    can_collide_ = std::make_shared<const std::function<bool(Index, Index)>>(std::move(can_collide));
}

Result<CollisionFilter> CollisionFilter::groups(std::vector<Index> group_of_vertex,
                                                std::span<const std::array<Index, 2>> excluded) {
  auto groups = std::make_shared<Groups>();
  for (std::size_t v = 0; v < group_of_vertex.size(); ++v) {
    if (group_of_vertex[v] > kMaxGroups) {
      return fail(ErrorCode::LimitExceeded, fmt::format("vertex {}", v),
                  fmt::format("is in group {}", group_of_vertex[v]),
                  fmt::format("number the groups from 0 to at most {}", kMaxGroups));
    }
    groups->count = std::max(groups->count, group_of_vertex[v] + 1);
  }
  groups->excluded.resize(std::size_t{groups->count} * groups->count);
  for (const auto& [a, b] : excluded) {
    if (std::max(a, b) >= groups->count) {
      return fail(ErrorCode::InvalidArgument, "excluded",
                  fmt::format("names group {}, but no vertex is in it", std::max(a, b)),
                  "name groups that have vertices");
    }
    groups->excluded[std::size_t{a} * groups->count + b] = true;
    groups->excluded[std::size_t{b} * groups->count + a] = true;
  }
  groups->of_vertex = std::move(group_of_vertex);
  CollisionFilter filter;
  filter.groups_ = std::move(groups);
  return filter;
}

Result<CollisionFilter> CollisionFilter::patches(std::vector<Index> patch_of_vertex) {
  std::vector<Index> present = patch_of_vertex;
  std::sort(present.begin(), present.end());
  present.erase(std::unique(present.begin(), present.end()), present.end());
  std::vector<std::array<Index, 2>> excluded;
  excluded.reserve(present.size());
  for (const Index patch : present) excluded.push_back({patch, patch});
  return groups(std::move(patch_of_vertex), excluded);
}

bool CollisionFilter::operator()(Index i, Index j) const {
  if (groups_ != nullptr) return groups_->allows(i, j);
  return can_collide_ == nullptr || (*can_collide_)(i, j);
}

bool CollisionFilter::allows_any(std::span<const Index> a, std::span<const Index> b) const {
  if (allows_all()) return true;
  for (const Index i : a) {
    for (const Index j : b) {
      if (i != j && (*this)(i, j)) return true;
    }
  }
  return false;
}

std::span<const Index> CollisionFilter::vertex_groups() const {
  return groups_ == nullptr ? std::span<const Index>() : std::span<const Index>(groups_->of_vertex);
}

Index CollisionFilter::vertex_count() const {
  return groups_ == nullptr ? kNoIndex : static_cast<Index>(groups_->of_vertex.size());
}

}  // namespace foldproof
