#include "contacts/curves.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <set>
#include <utility>

#include "check/motion.h"
#include "foldproof/ccd.h"

namespace foldproof::internal {
namespace {

// In [-1,1], from the bits of a coordinate.
double noise(double coordinate, std::uint64_t seed) {
  std::uint64_t h = (std::bit_cast<std::uint64_t>(coordinate + 0.0) ^ seed) * 0x9E3779B97F4A7C15u;
  h = (h ^ (h >> 32)) * 0xD1B54A32D192ED03u;
  return static_cast<double>(h >> 11) * 0x1p-52 - 1;
}

// Positions that are displaced a little.
class Displaced {
 public:
  Displaced(std::span<const CrossingPair> pairs, const Surfaces& surfaces, Positions x)
      : surfaces_(surfaces), x_(x) {
    double largest = 0;
    for (const CrossingPair& pair : pairs) {
      for (int side = 0; side < 2; ++side) {
        const Index object = pair.object(side);
        for (const Index v : surfaces.topology(object).triangles()[pair.triangle(side)])
          largest = std::max(largest, position(x[object], v).cwiseAbs().maxCoeff());
      }
    }
    scale_ = largest * 0x1p-40;
  }

  double scale() const { return scale_; }

  Vec3 at(Index object, Index vertex) const {
    const Vec3 p = position(x_[object], vertex);
    // The same for vertices of a seam, another for each closed surface.
    const Shells& shells = surfaces_.shells(object);
    const Index shell = shells.of(vertex);
    const std::uint64_t own = shell != kNoIndex && shells.is_closed(shell) ? shell + 1 : 0;
    const std::uint64_t seed = ((object + 1) + (own << 32)) * 0x632BE59BD9B4E019u;
    const double all = noise(p[0], seed) + noise(p[1], seed + 1) + noise(p[2], seed + 2);
    return p + scale_ * Vec3(noise(all, seed + 3), noise(all, seed + 4), noise(all, seed + 5));
  }

 private:
  const Surfaces& surfaces_;
  Positions x_;
  double scale_;
};

// One end of the segment in which two triangles cross.
struct End {
  Index pair;
  Piercing piercing;
};

// What a piercing is, whichever sides its pairs say: the face tells which object the edge is of.
using Identity = std::pair<Edge, Index>;

class Tracer {
 public:
  Tracer(const Surfaces& surfaces, std::span<const CrossingPair> pairs, Positions x, Curves& out)
      : surfaces_(surfaces), x_(pairs, surfaces, x), out_(out), pairs_(out.pairs) {
    pairs_.clear();
    out_.rounding = 8 * x_.scale();
    out_.pierced.clear();
    for (const CrossingPair& pair : pairs) {
      const bool face[] = {is_face(pair, 0), is_face(pair, 1)};
      if (face[0] && face[1]) pairs_.push_back(pair);
      if (face[0] != face[1]) add_pierced(pair, face[0] ? 1 : 0);
    }
    given_count_ = pairs.size();
  }

  void trace() {
    // A curve that leaves a pair's triangle through an edge goes on in the other triangles there.
    std::size_t done = 0;
    while (done < pairs_.size()) {
      const auto sorted = static_cast<std::ptrdiff_t>(ends_.size());
      for (; done < pairs_.size(); ++done) add_ends(static_cast<Index>(done));
      for (auto i = static_cast<Index>(sorted); i < ends_.size(); ++i)
        order_.emplace_back(Identity(ends_[i].piercing.edge, ends_[i].piercing.face), i);
      std::sort(order_.begin() + sorted, order_.end());
      std::inplace_merge(order_.begin(), order_.begin() + sorted, order_.end());
      add_missing_pairs();
    }
    out_.as_given = pairs_.size() == given_count_;
    number_piercings();
    out_.lines.clear();
    out_.closed = !out_.segments.empty();
    out_.at_borders = false;
    out_.length = 0;
    link_segments();
    for (Index n = 0; n < out_.piercings.size(); ++n) {
      const Index degree = first_[n + 1] - first_[n];
      if (degree % 2 != 0) {
        out_.closed = false;
        out_.at_borders |= out_.piercings[n].face != kNoIndex;
      }
      if (degree != 2) {
        while (next_segment(n) != kNoIndex) follow(n);
      }
    }
    for (Index n = 0; n < out_.piercings.size(); ++n) {
      if (next_segment(n) != kNoIndex) follow(n);
    }
  }

 private:
  using PairKey = std::array<Index, 4>;
  static PairKey key_of(const CrossingPair& pair) {
    return {pair.object(0), pair.triangle(0), pair.object(1), pair.triangle(1)};
  }

  bool is_face(const CrossingPair& pair, int side) const {
    return surfaces_.is_face(pair.object(side), pair.triangle(side));
  }

  // Where the line or point of `side` meets the face of the other.
  void add_pierced(const CrossingPair& pair, int side) {
    const Index object = pair.object(side), other = pair.object(1 - side);
    const Triangle &line = surfaces_.topology(object).triangles()[pair.triangle(side)],
                   &f = surfaces_.topology(other).triangles()[pair.triangle(1 - side)];
    const Vec3 p = x_.at(object, line[0]), q = x_.at(object, line[1]), corner = x_.at(other, f[0]);
    const Vec3 normal = (x_.at(other, f[1]) - corner).cross(x_.at(other, f[2]) - corner);
    const double from = normal.dot(p - corner), to = normal.dot(q - corner);
    const double share = from == to ? 0 : std::clamp(from / (from - to), 0.0, 1.0);
    out_.pierced.push_back(p + share * (q - p));
  }

  // Adds the pairs of triangles at pierced edges that are not there.
  void add_missing_pairs() {
    for (std::size_t i = 0; i < order_.size();) {
      std::size_t end = i + 1;
      while (end < order_.size() && order_[end].first == order_[i].first) ++end;
      const End& first = ends_[order_[i].second];
      const Piercing& p = first.piercing;
      if (p.face != kNoIndex && end - i < surfaces_.most_at_edge(p.object)) {
        surfaces_.triangles_with_edge(p.object, p.edge, at_edge_);
        for (std::size_t k = 0; k < at_edge_.size() && at_edge_.size() > end - i; ++k) {
          const Index t = at_edge_[k];
          const auto has = [&](const auto& e) {
            const End& end = ends_[e.second];
            return pairs_[end.pair].triangle(end.piercing.side) == t;
          };
          if (!surfaces_.is_face(p.object, t) ||
              std::any_of(order_.begin() + static_cast<std::ptrdiff_t>(i),
                          order_.begin() + static_cast<std::ptrdiff_t>(end), has))
            continue;
          CrossingPair pair = pairs_[first.pair];
          ((p.side == 0) != pair.reversed ? pair.triangles.triangle_a : pair.triangles.triangle_b) = t;
          if (added_.insert(key_of(pair)).second) pairs_.push_back(pair);
        }
      }
      i = end;
    }
  }

  // Where the edges of the triangle of `side` pass through the other triangle.
  void add_piercings(Index i, int side) {
    const CrossingPair pair = pairs_[i];
    const Index object = pair.object(side), other = pair.object(1 - side);
    const Triangle &t = surfaces_.topology(object).triangles()[pair.triangle(side)],
                   &f = surfaces_.topology(other).triangles()[pair.triangle(1 - side)];
    const std::array<Vec3, 3>&own = corners_[side], &corners = corners_[1 - side];
    std::array<int, 3> above{};  // 0 for a common vertex
    for (int k = 0; k < 3; ++k) {
      if (object != other || std::find(f.begin(), f.end(), t[k]) == f.end())
        above[k] = orient3d(corners[0], corners[1], corners[2], own[k]);
    }
    for (int k = 0; k < 3; ++k) {
      // An edge begins at its vertex of the smaller number.
      const int next = (k + 1) % 3, first = t[next] < t[k] ? next : k, last = first == k ? next : k;
      const Edge edge{t[first], t[last]};
      if (edge[0] == edge[1] || above[first] == 0 || above[last] != -above[first]) continue;
      const Vec3 &p = own[first], &q = own[last];
      const int turn = orient3d(p, q, corners[0], corners[1]);
      if (turn == 0 || orient3d(p, q, corners[1], corners[2]) != turn ||
          orient3d(p, q, corners[2], corners[0]) != turn)
        continue;
      const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
      const double from = normal.dot(p - corners[0]), to = normal.dot(q - corners[0]);
      const double share = from == to ? 0.5 : std::clamp(from / (from - to), 0.0, 1.0);
      ends_.push_back({i,
                       {side, object, edge, surfaces_.triangle(other, pair.triangle(1 - side)), share,
                        p + share * (q - p)}});
    }
  }

  void add_ends(Index i) {
    const CrossingPair pair = pairs_[i];
    const std::size_t before = ends_.size();
    for (int side = 0; side < 2; ++side) {
      if (i > 0 && pairs_[i - 1].triangle(side) == pair.triangle(side)) continue;  // as they are
      const Index object = pair.object(side);
      const Triangle& t = surfaces_.topology(object).triangles()[pair.triangle(side)];
      corners_[side] = {x_.at(object, t[0]), x_.at(object, t[1]), x_.at(object, t[2])};
    }
    add_piercings(i, 0);
    add_piercings(i, 1);
    if (pair.object(0) != pair.object(1)) return;
    const auto triangles = surfaces_.topology(pair.object(0)).triangles();
    const Triangle &s = triangles[pair.triangle(0)], &t = triangles[pair.triangle(1)];
    Index common = kNoIndex, count = 0;
    for (const Index v : s) {
      if (std::find(t.begin(), t.end(), v) != t.end()) common = v, ++count;
    }
    if (count == 1 && ends_.size() == before + 1) {
      ends_.push_back({i, {0, pair.object(0), {common, common}, kNoIndex, 0, x_.at(pair.object(0), common)}});
    }
  }

  // Lists each piercing once, and the segments by their numbers.
  void number_piercings() {
    out_.piercings.clear();
    out_.segments.clear();
    std::vector<std::array<Index, 2>> of_pair(pairs_.size(), {kNoIndex, kNoIndex});
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const End& end = ends_[order_[i].second];
      if (i == 0 || order_[i].first != order_[i - 1].first) out_.piercings.push_back(end.piercing);
      auto& both = of_pair[end.pair];
      (both[0] == kNoIndex ? both[0] : both[1]) = static_cast<Index>(out_.piercings.size() - 1);
    }
    for (Index i = 0; i < of_pair.size(); ++i) {
      if (of_pair[i][1] != kNoIndex) out_.segments.push_back({i, of_pair[i]});
    }
  }

  void link_segments() {
    first_.assign(out_.piercings.size() + 1, 0);
    for (const auto& segment : out_.segments) {
      for (const Index n : segment.ends) ++first_[n + 1];
    }
    for (std::size_t n = 1; n < first_.size(); ++n) first_[n] += first_[n - 1];
    at_.resize(2 * out_.segments.size());
    next_.assign(first_.begin(), first_.end() - 1);
    for (Index s = 0; s < out_.segments.size(); ++s) {
      for (const Index n : out_.segments[s].ends) at_[next_[n]++] = s;
    }
    next_.assign(first_.begin(), first_.end() - 1);
    used_.assign(out_.segments.size(), 0);
  }

  // A segment at a piercing that no line has yet.
  Index next_segment(Index n) {
    while (next_[n] < first_[n + 1] && used_[at_[next_[n]]]) ++next_[n];
    return next_[n] < first_[n + 1] ? at_[next_[n]] : kNoIndex;
  }

  // A line from a piercing to where it ends, branches or comes back.
  void follow(Index n) {
    auto& line = out_.lines.emplace_back(1, n);
    for (Index s = next_segment(n); s != kNoIndex; s = next_segment(n)) {
      used_[s] = 1;
      const auto& ends = out_.segments[s].ends;
      const Index to = ends[0] == n ? ends[1] : ends[0];
      out_.length += (out_.piercings[to].position - out_.piercings[n].position).norm();
      line.push_back(to);
      n = to;
      if (first_[n + 1] - first_[n] != 2) break;
    }
  }

  const Surfaces& surfaces_;
  Displaced x_;
  Curves& out_;
  std::vector<CrossingPair>& pairs_;
  std::size_t given_count_ = 0;
  std::set<PairKey> added_;
  std::vector<Index> at_edge_;
  std::array<std::array<Vec3, 3>, 2> corners_{};  // of the last pair of ends_, per side
  std::vector<End> ends_;
  std::vector<std::pair<Identity, Index>> order_;  // of ends_
  std::vector<Index> first_, at_, next_;           // segments at each piercing
  std::vector<std::uint8_t> used_;
};

}  // namespace

void trace_curves(const Surfaces& surfaces, std::span<const CrossingPair> pairs, Positions x, Curves& out) {
  Tracer(surfaces, pairs, x, out).trace();
}

}  // namespace foldproof::internal
