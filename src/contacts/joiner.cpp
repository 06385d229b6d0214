#include "contacts/joiner.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace foldproof::internal {

Index Joiner::Keys::find_row(Index vertex) const {
  if (vertex >= row_of.size()) return kNoIndex;
  const Index row = row_of[vertex];
  return row < rows.size() && rows[row] == vertex ? row : kNoIndex;
}

void Joiner::begin(std::size_t element_count) {
  std::swap(now_, before_);
  now_.row_of.resize(surfaces_.vertex_count());
  now_.rows.clear();
  unsorted_.clear();
  vertex_faces_.clear();
  links_.clear();
  links_.reserve(element_count);
  unsorted_.reserve(6 * element_count);
  folded_.assign(element_count, 0);
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

void Joiner::add_key(Index u, Index w, Index element) {
  const auto [smaller, larger] = std::minmax(u, w);
  Index row = now_.find_row(smaller);
  if (row == kNoIndex) {
    row = now_.row_of[smaller] = static_cast<Index>(now_.rows.size());
    now_.rows.push_back(smaller);
  }
  unsorted_.push_back({row, {larger, element, w < u}});
}

void Joiner::add(std::span<const Index> a, std::span<const Index> b) {
  const auto element = static_cast<Index>(links_.size());
  links_.push_back({element, false});
  // Vertices of both sides do not say which side is which.
  const auto is_in = [](std::span<const Index> all, Index v) {
    return std::find(all.begin(), all.end(), v) != all.end();
  };
  const bool has_own = !std::all_of(a.begin(), a.end(), [&](Index u) { return is_in(b, u); });
  const bool other_has_own = !std::all_of(b.begin(), b.end(), [&](Index w) { return is_in(a, w); });
  for (const Index u : a) {
    if (has_own && is_in(b, u)) continue;
    for (const Index w : b) {
      if (u != w && !(other_has_own && is_in(a, w))) add_key(u, w, element);
    }
  }
}

void Joiner::add(Index vertex, Index face, const Triangle& corners) {
  vertex_faces_.push_back({face, vertex, static_cast<Index>(links_.size())});
  add(std::span(&vertex, 1), corners);
}

// Sorts the keys into rows; in a row they are in the order of their elements.
void Joiner::sort_keys() {
  now_.begin.assign(now_.rows.size() + 1, 0);
  for (const Unsorted& key : unsorted_) ++now_.begin[key.row + 1];
  for (std::size_t row = 0; row < now_.rows.size(); ++row) now_.begin[row + 1] += now_.begin[row];
  std::vector<Index> next(now_.begin.begin(), now_.begin.end() - 1);
  now_.keys.resize(unsorted_.size());
  for (const Unsorted& key : unsorted_) now_.keys[next[key.row]++] = key.key;
}

void Joiner::note(Index element, const Label& label) {
  if (found_.empty() || found_.back().first != element || found_.back().second.number != label.number ||
      found_.back().second.reversed != label.reversed)
    found_.emplace_back(element, label);
}

// Joins what has a key in common, keeps the first of these keys, and notes labels of the last slice.
void Joiner::join_rows() {
  first_now_.resize(surfaces_.vertex_count());
  first_before_.resize(surfaces_.vertex_count());
  Index kept = 0;
  for (std::size_t row = 0; row < now_.rows.size(); ++row) {
    const Index before = before_.find_row(now_.rows[row]);
    const Index old_begin = before == kNoIndex ? 0 : before_.begin[before],
                old_end = before == kNoIndex ? 0 : before_.begin[before + 1];
    for (Index i = old_begin; i < old_end; ++i) first_before_[before_.keys[i].larger] = i;
    const Index begin = std::exchange(now_.begin[row], kept), end = now_.begin[row + 1];
    for (Index i = begin; i < end; ++i) {
      const Key key = now_.keys[i];
      const Index first = first_now_[key.larger];
      if (first >= now_.begin[row] && first < kept && now_.keys[first].larger == key.larger) {
        join(now_.keys[first].element, key.element, now_.keys[first].reversed != key.reversed);
        continue;
      }
      first_now_[key.larger] = kept;
      now_.keys[kept++] = key;
      const Index known = first_before_[key.larger];
      if (known < old_begin || known >= old_end || before_.keys[known].larger != key.larger) continue;
      const Key& old = before_.keys[known];
      const Label& label = before_.labels[old.element];
      note(key.element, {label.number, (label.reversed != old.reversed) != key.reversed});
    }
  }
  now_.begin.back() = kept;
  now_.keys.resize(kept);
}

// Joins neighboring vertices that meet one face.
void Joiner::join_neighbors() {
  std::sort(vertex_faces_.begin(), vertex_faces_.end(), [](const VertexFace& a, const VertexFace& b) {
    return std::tie(a.face, a.element) < std::tie(b.face, b.element);
  });
  for (std::size_t i = 0; i < vertex_faces_.size();) {
    std::size_t end = i + 1;
    while (end < vertex_faces_.size() && vertex_faces_[end].face == vertex_faces_[i].face) ++end;
    const auto place = [&](Index vertex) { return first_now_[vertex]; };
    for (std::size_t k = i; k < end; ++k) first_now_[vertex_faces_[k].vertex] = static_cast<Index>(k);
    for (std::size_t k = i; k < end && end - i > 1; ++k) {
      surfaces_.for_each_higher_neighbor(vertex_faces_[k].vertex, [&](Index neighbor) {
        const Index other = place(neighbor);
        if (other >= i && other < end && vertex_faces_[other].vertex == neighbor)
          join(vertex_faces_[k].element, vertex_faces_[other].element, false);
      });
    }
    i = end;
  }
}

// A group that has no key in common with the last slice continues what has a neighboring one.
void Joiner::continue_neighbors() {
  if (before_.rows.empty()) return;
  std::vector<std::uint8_t> is_new(links_.size(), 1);  // per root
  for (const auto& [element, label] : found_) is_new[find_root(element).parent] = 0;
  for (std::size_t row = 0; row < now_.rows.size(); ++row) {
    for (Index i = now_.begin[row]; i < now_.begin[row + 1]; ++i) {
      const Key& key = now_.keys[i];
      if (!is_new[find_root(key.element).parent]) continue;
      const auto look_up = [&](Index fixed, Index neighbor) {
        const Index found = before_.find_row(std::min(fixed, neighbor));
        if (found == kNoIndex) return;
        const bool exchanged = (fixed == key.larger) != (neighbor < fixed);
        for (Index k = before_.begin[found]; k < before_.begin[found + 1]; ++k) {
          const Key& old = before_.keys[k];
          if (old.larger != std::max(fixed, neighbor)) continue;
          const Label& label = before_.labels[old.element];
          note(key.element, {label.number, ((label.reversed != old.reversed) != key.reversed) != exchanged});
        }
      };
      const Index smaller = now_.rows[row];
      surfaces_.for_each_neighbor(smaller, [&](Index v) { look_up(key.larger, v); });
      surfaces_.for_each_neighbor(key.larger, [&](Index v) { look_up(smaller, v); });
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
  sort_keys();
  join_rows();
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
