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

std::uint64_t key_of(Index u, Index w) { return std::uint64_t{std::min(u, w)} << 32 | std::max(u, w); }

// The vertices of a key.
std::array<Index, 2> vertices_of(std::uint64_t key) {
  return {static_cast<Index>(key >> 32), static_cast<Index>(key)};
}

}  // namespace

Index& Joiner::Map::slot(std::uint64_t key) {
  const std::size_t mask = slots.size() - 1;
  std::size_t i = place_of(key) & mask;
  while (slots[i] != kNoIndex && entries[slots[i]].key != key) i = (i + 1) & mask;
  return slots[i];
}

const Joiner::Entry* Joiner::Map::find(std::uint64_t key) const {
  if (entries.empty()) return nullptr;
  const std::size_t mask = slots.size() - 1;
  std::size_t i = place_of(key) & mask;
  while (slots[i] != kNoIndex && entries[slots[i]].key != key) i = (i + 1) & mask;
  return slots[i] == kNoIndex ? nullptr : &entries[slots[i]];
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
void Joiner::add_key(std::uint64_t key, bool reversed, std::array<bool, 2> is_vertex) {
  const auto element = static_cast<Index>(links_.size() - 1);
  Index& slot = now_.slot(key);
  if (slot != kNoIndex) {
    Entry& entry = now_.entries[slot];
    for (std::size_t k = 0; k < 2; ++k) entry.is_vertex[k] |= is_vertex[k];
    if (entry.element != element) join(entry.element, element, entry.reversed != reversed);
    return;
  }
  slot = static_cast<Index>(now_.entries.size());
  now_.entries.push_back({key, {}, element, reversed, is_vertex});
  const Entry* old = before_.find(key);
  if (old == nullptr) return;
  const Label label{old->label.number, old->label.reversed != reversed};
  if (found_.empty() || found_.back().first != element || found_.back().second.number != label.number ||
      found_.back().second.reversed != label.reversed)
    found_.emplace_back(element, label);
}

void Joiner::add(std::span<const Index> a, std::span<const Index> b) {
  links_.push_back({static_cast<Index>(links_.size()), false});
  folded_.push_back(0);
  // Vertices of both sides do not say which side is which.
  const auto has = [](std::span<const Index> all, Index v) {
    return std::find(all.begin(), all.end(), v) != all.end();
  };
  const auto only = [&](std::span<const Index> all, std::span<const Index> other, Index v) {
    return !has(other, v) || std::all_of(all.begin(), all.end(), [&](Index w) { return has(other, w); });
  };
  keys_.clear();
  for (const Index u : a) {
    if (!only(a, b, u)) continue;
    for (const Index w : b) {
      if (u != w && only(b, a, w)) keys_.emplace_back(key_of(u, w), w < u);
    }
  }
  now_.make_room(keys_.size());
  fetch_keys();
  for (const auto& [key, reversed] : keys_) {
    const std::array<bool, 2> side{a.size() == 1 && b.size() == 3, b.size() == 1 && a.size() == 3};
    add_key(key, reversed, {side[reversed ? 1 : 0], side[reversed ? 0 : 1]});
  }
}

// Joins elements of a vertex and a face each whose vertices are neighbors.
void Joiner::join_neighbors() {
  for (const Entry& entry : now_.entries) {
    const std::array<Index, 2> vertices = vertices_of(entry.key);
    for (std::size_t k = 0; k < 2; ++k) {
      if (!entry.is_vertex[k]) continue;
      const Index other = vertices[1 - k];
      surfaces_.for_each_higher_neighbor(vertices[k], [&](Index neighbor) {
        if (neighbor == other) return;
        const Entry* found = now_.find(key_of(neighbor, other));
        if (found == nullptr || !found->is_vertex[neighbor < other ? 0 : 1]) return;
        const bool exchanged = (vertices[k] < other) != (neighbor < other);
        join(entry.element, found->element, (entry.reversed != found->reversed) != exchanged);
      });
    }
  }
}

// A group that has no key in common with the last slice continues what has a neighboring one.
void Joiner::continue_neighbors() {
  if (before_.entries.empty()) return;
  std::vector<std::uint8_t> is_new(links_.size(), 1);  // per root
  for (const auto& [element, label] : found_) is_new[find_root(element).parent] = 0;
  for (const Entry& entry : now_.entries) {
    if (!is_new[find_root(entry.element).parent]) continue;
    const std::array<Index, 2> vertices = vertices_of(entry.key);
    for (std::size_t k = 0; k < 2; ++k) {
      const Index other = vertices[1 - k];
      surfaces_.for_each_neighbor(vertices[k], [&](Index neighbor) {
        if (neighbor == other) return;
        const Entry* old = before_.find(key_of(neighbor, other));
        if (old == nullptr) return;
        const bool exchanged = (vertices[k] < other) != (neighbor < other);
        found_.emplace_back(entry.element,
                            Label{old->label.number, (old->label.reversed != entry.reversed) != exchanged});
      });
    }
  }
}

void Joiner::list_groups() {
  groups_.group.assign(links_.size(), kNoIndex);
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
    const Label seen{label.number, label.reversed != static_cast<bool>(groups_.reversed[element])};
    auto& labels = groups_.labels[groups_.group[element]];
    if (labels.empty() || labels.back().number != seen.number || labels.back().reversed != seen.reversed)
      labels.push_back(seen);
  }
}

const Joiner::Groups& Joiner::find_groups() {
  join_neighbors();
  continue_neighbors();
  list_groups();
  return groups_;
}

void Joiner::end(std::span<const Label> labels) {
  for (Entry& entry : now_.entries) {
    const Label& label = labels[groups_.group[entry.element]];
    entry.label = {label.number,
                   (label.reversed != static_cast<bool>(groups_.reversed[entry.element])) != entry.reversed};
  }
}

}  // namespace foldproof::internal
