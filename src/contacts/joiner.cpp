#include "contacts/joiner.h"

#include <algorithm>
#include <bit>
#include <tuple>
#include <utility>

namespace foldproof::internal {

void Joiner::Keys::clear(std::size_t expected) {
  keys_.clear();
  keys_.reserve(expected);
  resize(4 * expected);
}

// Where a key is in the table, or would be.
std::size_t Joiner::Keys::slot_of(Index smaller, Index larger) const {
  // Keys with near vertices are mostly near each other in the table: such are looked for one after the other.
  constexpr int kNear = 4;
  const std::uint64_t h = (std::uint64_t{smaller} << 32 | larger >> kNear) * 0x9E3779B97F4A7C15u;
  std::size_t slot = h >> shift_ << kNear | (larger & ((1u << kNear) - 1));
  const auto is_other = [&](Index i) {
    return i != kNoIndex && (keys_[i].smaller != smaller || keys_[i].larger != larger);
  };
  while (is_other(slots_[slot])) slot = (slot + 1) & (slots_.size() - 1);
  return slot;
}

void Joiner::Keys::resize(std::size_t least) {
  slots_.assign(std::bit_ceil(std::max(least, std::size_t{64})), kNoIndex);
  shift_ = 64 + 4 - std::countr_zero(slots_.size());
  for (Index i = 0; i < keys_.size(); ++i) slots_[slot_of(keys_[i].smaller, keys_[i].larger)] = i;
}

const Joiner::Key* Joiner::Keys::find(Index u, Index w) const {
  if (keys_.empty()) return nullptr;
  const Index place = slots_[slot_of(std::min(u, w), std::max(u, w))];
  return place == kNoIndex ? nullptr : &keys_[place];
}

std::pair<Joiner::Key, bool> Joiner::Keys::add(const Key& key) {
  if (2 * keys_.size() >= slots_.size()) resize(2 * slots_.size());
  Index& place = slots_[slot_of(key.smaller, key.larger)];
  if (place != kNoIndex) return {keys_[place], false};
  place = static_cast<Index>(keys_.size());
  keys_.push_back(key);
  return {key, true};
}

void Joiner::begin(std::size_t element_count) {
  std::swap(now_, before_);
  now_.clear(element_count);
  vertex_faces_.clear();
  links_.clear();
  links_.reserve(element_count);
  folded_.assign(element_count, 0);
  found_.clear();
  seen_.resize(surfaces_.vertex_count());
  run_of_.clear();
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

// Joins an element with the first that has the key, or notes what the last slice says of it.
void Joiner::add_key(Index u, Index w, Index element) {
  const auto [smaller, larger] = std::minmax(u, w);
  const auto [key, is_new] = now_.add({smaller, larger, element, w < u});
  if (!is_new) {
    join(key.element, element, key.reversed != (w < u));
  } else if (const Key* old = before_.find(u, w)) {
    note(key, *old, false);
  }
}

void Joiner::add(std::span<const Index> a, std::span<const Index> b) {
  const auto element = static_cast<Index>(links_.size());
  links_.push_back({element, false});
  const auto is_in = [](std::span<const Index> all, Index v) {
    return std::find(all.begin(), all.end(), v) != all.end();
  };
  if (std::none_of(a.begin(), a.end(), [&](Index u) { return is_in(b, u); })) return add_apart(a, b, element);
  // Vertices of both sides do not say which side is which.
  const bool has_own = !std::all_of(a.begin(), a.end(), [&](Index u) { return is_in(b, u); });
  const bool other_has_own = !std::all_of(b.begin(), b.end(), [&](Index w) { return is_in(a, w); });
  for (const Index u : a) {
    if (has_own && is_in(b, u)) continue;
    for (const Index w : b) {
      if (u != w && !(other_has_own && is_in(a, w))) add_key(u, w, element);
    }
  }
}

// The same for features without a common vertex. Elements come in runs with one and the same feature first:
// of those with a vertex of the other side in common, only the first needs keys of it.
void Joiner::add_apart(std::span<const Index> a, std::span<const Index> b, Index element) {
  if (!std::equal(a.begin(), a.end(), run_of_.begin(), run_of_.end())) {
    run_of_.assign(a.begin(), a.end());
    if (++run_ == 0) std::fill(seen_.begin(), seen_.end(), Seen{}), run_ = 1;
  }
  for (const Index w : b) {
    Seen& seen = seen_[w];
    if (seen.run == run_) {
      join(seen.element, element, false);
      continue;
    }
    seen = {run_, element};
    for (const Index u : a) add_key(u, w, element);
  }
}

void Joiner::add(Index vertex, Index face, const Triangle& corners) {
  vertex_faces_.push_back({face, vertex, static_cast<Index>(links_.size())});
  add(std::span(&vertex, 1), corners);
}

// A key of the last slice says which contact one of this slice continues.
void Joiner::note(const Key& key, const Key& old, bool exchanged) {
  const Label& label = before_.labels[old.element];
  const bool reversed = ((label.reversed != old.reversed) != key.reversed) != exchanged;
  if (found_.empty() || found_.back().first != key.element || found_.back().second.number != label.number ||
      found_.back().second.reversed != reversed)
    found_.push_back({key.element, {label.number, reversed}});
}

// Joins neighboring vertices that meet one face.
void Joiner::join_neighbors() {
  place_.resize(surfaces_.vertex_count());
  std::sort(vertex_faces_.begin(), vertex_faces_.end(), [](const VertexFace& a, const VertexFace& b) {
    return std::tie(a.face, a.element) < std::tie(b.face, b.element);
  });
  for (std::size_t i = 0; i < vertex_faces_.size();) {
    std::size_t end = i + 1;
    while (end < vertex_faces_.size() && vertex_faces_[end].face == vertex_faces_[i].face) ++end;
    for (std::size_t k = i; k < end; ++k) place_[vertex_faces_[k].vertex] = static_cast<Index>(k);
    for (std::size_t k = i; k < end && end - i > 1; ++k) {
      surfaces_.for_each_higher_neighbor(vertex_faces_[k].vertex, [&](Index neighbor) {
        const Index other = place_[neighbor];
        if (other >= i && other < end && vertex_faces_[other].vertex == neighbor)
          join(vertex_faces_[k].element, vertex_faces_[other].element, false);
      });
    }
    i = end;
  }
}

// A group that has no key in common with the last slice continues what has a neighboring one. The edges of a
// vertex that has many are seen from their lower vertices, which either slice may have: each vertex has few.
void Joiner::continue_neighbors() {
  std::vector<std::uint8_t> is_new(links_.size(), 1);  // per root
  for (const auto& [element, label] : found_) is_new[find_root(element).parent] = 0;
  const auto look_up = [&](const Key& key, const Keys& others, Index vertex, Index neighbor, auto visit) {
    const Index common = vertex == key.larger ? key.smaller : key.larger;
    const Key* other = others.find(common, neighbor);
    if (other) visit(*other, (common == key.larger) != (common == other->larger));
  };
  constexpr std::size_t kMany = 64;
  bool some_have_many = false;
  for (const Key& key : now_.all()) {
    if (!is_new[find_root(key.element).parent]) continue;
    for (const Index vertex : {key.smaller, key.larger}) {
      const auto visit = [&](Index neighbor) {
        look_up(key, before_, vertex, neighbor,
                [&](const Key& old, bool exchanged) { note(key, old, exchanged); });
      };
      if (surfaces_.neighbor_count(vertex) <= kMany) {
        surfaces_.for_each_neighbor(vertex, visit);
      } else {
        surfaces_.for_each_higher_neighbor(vertex, visit);
        some_have_many = true;
      }
    }
  }
  for (std::size_t i = 0; i < before_.all().size() && some_have_many; ++i) {
    const Key& old = before_.all()[i];
    for (const Index vertex : {old.smaller, old.larger}) {
      surfaces_.for_each_higher_neighbor(vertex, [&](Index neighbor) {
        look_up(old, now_, vertex, neighbor, [&](const Key& key, bool exchanged) {
          if (is_new[find_root(key.element).parent]) note(key, old, exchanged);
        });
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
  now_.labels.resize(links_.size());
  for (Index e = 0; e < links_.size(); ++e) {
    const Label& label = labels[groups_.group[e]];
    now_.labels[e] = {label.number, label.reversed != static_cast<bool>(groups_.reversed[e])};
  }
}

}  // namespace foldproof::internal
