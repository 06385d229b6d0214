#include "certificate/plane.h"

#include <algorithm>
#include <bit>

namespace foldproof {
namespace {
constexpr std::uint32_t kEmpty =
    0xFFFFFFFF;  // an edge from a vertex to itself, which no triangle with area has
}

void DirectedEdges::reset(std::size_t most) {
  const std::size_t size = std::bit_ceil(std::max<std::size_t>(16, 2 * most));
  shift_ = 32 - std::countr_zero(size);
  table_.assign(size, kEmpty);
}

bool DirectedEdges::insert(std::uint16_t from, std::uint16_t to) {
  const std::uint32_t k = key(from, to);
  std::size_t at = slot(k);
  for (; table_[at] != kEmpty; at = (at + 1) & (table_.size() - 1)) {
    if (table_[at] == k) return false;
  }
  table_[at] = k;
  return true;
}

bool DirectedEdges::contains(std::uint16_t from, std::uint16_t to) const {
  const std::uint32_t k = key(from, to);
  std::size_t at = slot(k);
  for (; table_[at] != kEmpty; at = (at + 1) & (table_.size() - 1)) {
    if (table_[at] == k) return true;
  }
  return false;
}

void EdgeOwners::reset(std::size_t most) {
  const std::size_t size = std::bit_ceil(std::max<std::size_t>(16, 2 * most));
  shift_ = 32 - std::countr_zero(size);
  table_.assign(size, {kEmpty, kNobody});
}

std::size_t EdgeOwners::find(std::uint32_t key) const {
  std::size_t at = (key * 0x9E3779B1u) >> shift_;
  while (table_[at].key != key && table_[at].key != kEmpty) at = (at + 1) & (table_.size() - 1);
  return at;
}

void EdgeOwners::set(std::uint16_t from, std::uint16_t to, std::uint32_t owner) {
  const std::uint32_t key = std::uint32_t{from} << 16 | to;
  table_[find(key)] = {key, owner};
}

std::uint32_t EdgeOwners::owner(std::uint16_t from, std::uint16_t to) const {
  return table_[find(std::uint32_t{from} << 16 | to)].owner;
}

}  // namespace foldproof
