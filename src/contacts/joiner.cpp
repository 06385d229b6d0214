#include "contacts/joiner.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <bit>

namespace foldproof::internal {
namespace {

// Where a key's slot is looked for first. Keys whose last bits alone differ, which come one after the other,
// are neighbors.
std::uint64_t place_of(std::uint64_t key) {
  constexpr std::uint64_t kNeighbors = 15;
  const std::uint64_t block = (key & ~kNeighbors) * 0x9E3779B97F4A7C15u;
  return (block ^ (block >> 29)) + (key & kNeighbors);
}

}  // namespace

Index& Joiner::Map::slot(std::uint64_t key) {
  const std::size_t mask = slots.size() - 1;
  std::size_t i = place_of(key) & mask;
  while (slots[i] != kNoIndex && entries[slots[i]].key != key) i = (i + 1) & mask;
  return slots[i];
}

void Joiner::Map::make_room(std::size_t count) {
  const std::size_t needed = std::bit_ceil(2 * (entries.size() + count));
  if (needed <= slots.size()) return;
  slots.assign(std::max<std::size_t>(64, needed), kNoIndex);
  for (Index i = 0; i < entries.size(); ++i) slot(entries[i].key) = i;
}

void Joiner::Map::clear() {
  entries.clear();
  std::fill(slots.begin(), slots.end(), kNoIndex);
}

void Joiner::begin(std::size_t element_count) {
  std::swap(now_, before_);
  now_.clear();
  links_.clear();
  links_.reserve(element_count);
  folded_.clear();
  found_.clear();
}

Joiner::Link Joiner::find_root(Index element) {
  Link link{element, false};
  while (links_[link.parent].parent != link.parent) {
    const Link next = links_[link.parent];
    link = {next.parent, link.reversed != next.reversed};
  }
  // The next search is shorter.
  bool reversed = link.reversed;
  for (Index e = element; links_[e].parent != link.parent && e != link.parent;) {
    const Link next = links_[e];
    links_[e] = {link.parent, reversed};
    reversed = reversed != next.reversed;
    e = next.parent;
  }
  return link;
}

void Joiner::join(Index a, Index b, bool reversed) {
  const Link root_a = find_root(a), root_b = find_root(b);
  const bool relation = (root_a.reversed != root_b.reversed) != reversed;
  if (root_a.parent == root_b.parent) {
    folded_[root_a.parent] |= relation;
    return;
  }
  // The first element is the root, so that groups are in order.
  const auto [root, child] = std::minmax(root_a.parent, root_b.parent);
  links_[child] = {root, relation};
  folded_[root] |= folded_[child];
}

// Fetches what the newest element's keys will look for, all at once.
void Joiner::fetch_keys() {
  const std::size_t mask = now_.slots.size() - 1;
  for (const auto& [key, reversed] : keys_) hwy::Prefetch(&now_.slots[place_of(key) & mask]);
  for (const auto& [key, reversed] : keys_) {
    const Index likely = now_.slots[place_of(key) & mask];
    if (likely != kNoIndex) hwy::Prefetch(&now_.entries[likely]);
  }
}

// A key of the newest element.
void Joiner::add_key(std::uint64_t key, bool reversed) {
  const auto element = static_cast<Index>(links_.size() - 1);
  Index& slot = now_.slot(key);
  if (slot != kNoIndex) {
    const Entry& entry = now_.entries[slot];
    if (entry.element != element) join(entry.element, element, entry.reversed != reversed);
    return;
  }
  slot = static_cast<Index>(now_.entries.size());
  now_.entries.push_back({key, {}, element, reversed});
  if (before_.entries.empty()) return;
  const Index known = before_.slot(key);
  if (known == kNoIndex) return;
  const Entry& old = before_.entries[known];
  const Label label{old.label.number, old.label.reversed != reversed};
  if (found_.empty() || found_.back().first != element || found_.back().second.number != label.number ||
      found_.back().second.reversed != label.reversed)
    found_.emplace_back(element, label);
}

void Joiner::add(std::span<const Index> a, std::span<const Index> b) {
  links_.push_back({static_cast<Index>(links_.size()), false});
  folded_.push_back(0);
  // Vertices of both sides do not say which side is which.
  const auto without = [](std::span<const Index> all, std::span<const Index> other, std::vector<Index>& out) {
    out.clear();
    for (const Index v : all) {
      if (std::find(other.begin(), other.end(), v) == other.end()) out.push_back(v);
    }
    if (out.empty()) out.assign(all.begin(), all.end());
  };
  without(a, b, only_a_);
  without(b, a, only_b_);
  keys_.clear();
  for (const Index u : only_a_) {
    for (const Index w : only_b_) {
      if (u != w) keys_.emplace_back(std::uint64_t{std::min(u, w)} << 32 | std::max(u, w), w < u);
    }
  }
  now_.make_room(keys_.size());
  fetch_keys();
  for (const auto& [key, reversed] : keys_) add_key(key, reversed);
}

const Joiner::Groups& Joiner::groups() {
  constexpr Index kNone = kNoIndex;
  groups_.group.assign(links_.size(), kNone);
  groups_.reversed.assign(links_.size(), 0);
  groups_.labels.clear();
  groups_.folded.clear();
  for (Index e = 0; e < links_.size(); ++e) {
    const Link root = find_root(e);
    if (root.parent == e) {
      groups_.group[e] = static_cast<Index>(groups_.folded.size());
      groups_.folded.push_back(folded_[e]);
    } else {
      groups_.group[e] = groups_.group[root.parent];
    }
    groups_.reversed[e] = root.reversed;
  }
  groups_.labels.resize(groups_.folded.size());
  for (const auto& [element, label] : found_) {
    groups_.labels[groups_.group[element]].push_back(
        {label.number, label.reversed != static_cast<bool>(groups_.reversed[element])});
  }
  return groups_;
}

void Joiner::end(std::span<const Label> labels) {
  for (Entry& entry : now_.entries) {
    const Label& label = labels[groups_.group[entry.element]];
    entry.label = {label.number,
                   (label.reversed != static_cast<bool>(groups_.reversed[entry.element])) != entry.reversed};
  }
}

void Joiner::clear() { now_.clear(); }

}  // namespace foldproof::internal
