#include "report/coincidences.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/grouped.h"
#include "io/readers.h"

namespace foldproof::internal {
void Coincidences::add(Index frame, Positions x) {
  const bool first_frame = objects_.empty();
  if (first_frame) first_frame_ = frame;
  several_frames_ |= frame != first_frame_;
  objects_.resize(motions_.size());
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const auto at = [&](Index v) { return x[i].subspan(3 * std::size_t{v}).first<3>(); };
    const auto coincide = [&](Index v, Index w) {
      return std::equal(at(v).begin(), at(v).end(), at(w).begin());
    };
    Found& found = objects_[i];
    if (first_frame) {
      const Topology& topology = motions_[i]->topology();
      const std::vector<bool> named = io::named_vertices(topology.vertex_count(), topology.triangles());
      std::vector<Index> vertices;
      std::vector<double> positions;
      for (Index v = 0; v < named.size(); ++v) {
        if (!named[v]) continue;
        vertices.push_back(v);
        positions.insert(positions.end(), at(v).begin(), at(v).end());
      }
      const std::vector<Index> first = io::first_at_same_place(positions);
      for (std::size_t k = 0; k < first.size(); ++k) {
        if (first[k] != k) found.pairs.push_back({vertices[k], vertices[first[k]], false});
      }
      continue;
    }
    for (Pair& pair : found.pairs) {
      if (pair.parted || coincide(pair.vertex, pair.first)) continue;
      pair.parted = true;
      if (found.parted++ == 0) found.parted_frame = frame;
    }
  }
}

std::vector<CheckTotals::Notice> Coincidences::notices() const {
  std::vector<CheckTotals::Notice> notices;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const Found& found = objects_[i];
    if (found.pairs.empty()) continue;
    const std::string some = fmt::format(
        "{} of {} vertices {} exactly where others do", grouped(found.pairs.size()),
        grouped(motions_[i]->topology().vertex_count()), found.pairs.size() == 1 ? "lies" : "lie");
    notices.push_back(
        {static_cast<Index>(i),
         found.parted == 0
             ? fmt::format("{}{}, and so triangles touch there; if they are of one surface, check it with "
                           "--weld",
                           some, several_frames_ ? " in all frames" : "")
             : fmt::format("{} at first, and so triangles touch there; {} of them part in frame {} or later, "
                           "and --weld refuses to merge these",
                           some, grouped(found.parted), found.parted_frame)});
  }
  return notices;
}

}  // namespace foldproof::internal
