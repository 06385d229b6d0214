#include "adversary/pairs.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cstring>
#include <set>

#include "oracle/brute_force.h"

namespace foldproof::adversary {
namespace {

using oracle::Kind;

// How many questions of a step exact arithmetic is asked at most: it costs as much as all the rest.
constexpr int kMaxExact = 12, kMaxApproaches = 4;

struct Feature {
  std::array<Index, 3> vertices;
  int count;
  double low[2][3], high[2][3];
};

// All features of one sort of an object, with their boxes at both ends.
template <class List>
std::vector<Feature> features(const List& list, const Pose& x0, const Pose& x1) {
  std::vector<Feature> all;
  for (const auto& ids : list) {
    Feature f{};
    f.count = static_cast<int>(ids.size());
    std::copy(ids.begin(), ids.end(), f.vertices.begin());
    for (int end = 0; end < 2; ++end) {
      const Pose& x = end == 0 ? x0 : x1;
      for (int axis = 0; axis < 3; ++axis) {
        f.low[end][axis] = f.high[end][axis] = x[3 * ids[0] + axis];
        for (const Index v : ids) {
          f.low[end][axis] = std::min(f.low[end][axis], x[3 * v + axis]);
          f.high[end][axis] = std::max(f.high[end][axis], x[3 * v + axis]);
        }
      }
    }
    all.push_back(f);
  }
  return all;
}

// One rounding per difference, which the factor covers.
bool boxes_beyond(const Feature& a, const Feature& b, double bound) {
  for (int axis = 0; axis < 3; ++axis) {
    if (b.low[0][axis] - a.high[0][axis] > bound && b.low[1][axis] - a.high[1][axis] > bound) return true;
    if (a.low[0][axis] - b.high[0][axis] > bound && a.low[1][axis] - b.high[1][axis] > bound) return true;
  }
  return false;
}

bool share(const Feature& a, const Feature& b) {
  for (int i = 0; i < a.count; ++i) {
    for (int k = 0; k < b.count; ++k) {
      if (a.vertices[i] == b.vertices[k]) return true;
    }
  }
  return false;
}

class StepCheck {
 public:
  StepCheck(const Case& c, const Step& step, const StepResult& answer, std::mt19937_64& rng, Tally& tally)
      : case_(c), step_(step), answer_(answer), rng_(rng), tally_(tally) {
    ccd_.thickness = step.settings.thickness;
    ccd_.tolerance = answer.tolerance;
    bound_ = (ccd_.thickness + ccd_.tolerance) * (1 + 0x1p-40);
  }

  std::string run() {
    const auto count = static_cast<Index>(case_.objects.size());
    for (Index k = 0; k < count; ++k) {
      const Object& o = case_.objects[k];
      std::set<std::array<Index, 1>> used;
      for (const Triangle& t : o.triangles) {
        for (const Index v : t) used.insert({v});
      }
      vertices_.push_back(features(used, step_.x0[k], step_.x1[k]));
      faces_.push_back(features(o.triangles, step_.x0[k], step_.x1[k]));
      edges_.push_back(features(edges_of(o), step_.x0[k], step_.x1[k]));
    }
    for (Index a = 0; a < count; ++a) {
      for (Index b = 0; b < count; ++b) {
        if (!(a == b ? step_.settings.within : step_.settings.between)) continue;
        vertices_and_faces(a, b);
        if (a <= b) edges_and_edges(a, b);
        if (!complaint_.empty()) return complaint_;
      }
    }
    if (found_ != answer_.vertex_face.size() + answer_.edge_edge.size()) {
      return fmt::format("{} pairs are reported, but {} of them are pairs that may be",
                         answer_.vertex_face.size() + answer_.edge_edge.size(), found_);
    }
    return {};
  }

 private:
  void vertices_and_faces(Index a, Index b) {
    for (const Feature& v : vertices_[a]) {
      for (Index f = 0; f < faces_[b].size(); ++f) {
        const Feature& face = faces_[b][f];
        if (a == b && share(v, face)) continue;
        const oracle::PairKey key{a, v.vertices[0], b, f, 0, 0};
        const auto at = std::lower_bound(answer_.vertex_face.begin(), answer_.vertex_face.end(), key,
                                         [](const auto& c, const auto& k) { return oracle::key(c) < k; });
        const bool reported = at != answer_.vertex_face.end() && oracle::key(*at) == key;
        if (boxes_beyond(v, face, bound_) && !reported) continue;
        const auto points = [&](const Poses& x) {
          return FourPoints{point(x[a], v.vertices[0]), point(x[b], face.vertices[0]),
                            point(x[b], face.vertices[1]), point(x[b], face.vertices[2])};
        };
        look({Kind::VertexFace, points(step_.x0), points(step_.x1)}, reported ? &at->toi : nullptr,
             reported ? at->answer : Answer::Separated);
        if (complaint_.empty()) continue;
        complaint_ += fmt::format("\nvertex {} of object {}, face {} of object {}", v.vertices[0], a, f, b);
        return;
      }
    }
  }

  void edges_and_edges(Index a, Index b) {
    for (std::size_t i = 0; i < edges_[a].size(); ++i) {
      for (std::size_t k = a == b ? i + 1 : 0; k < edges_[b].size(); ++k) {
        const Feature &e = edges_[a][i], &g = edges_[b][k];
        if (a == b && share(e, g)) continue;
        const oracle::PairKey key{a, e.vertices[0], e.vertices[1], b, g.vertices[0], g.vertices[1]};
        const auto at = std::lower_bound(answer_.edge_edge.begin(), answer_.edge_edge.end(), key,
                                         [](const auto& c, const auto& k) { return oracle::key(c) < k; });
        const bool reported = at != answer_.edge_edge.end() && oracle::key(*at) == key;
        if (boxes_beyond(e, g, bound_) && !reported) continue;
        const auto points = [&](const Poses& x) {
          return FourPoints{point(x[a], e.vertices[0]), point(x[a], e.vertices[1]),
                            point(x[b], g.vertices[0]), point(x[b], g.vertices[1])};
        };
        look({Kind::EdgeEdge, points(step_.x0), points(step_.x1)}, reported ? &at->toi : nullptr,
             reported ? at->answer : Answer::Separated);
        if (complaint_.empty()) continue;
        complaint_ += fmt::format("\nedge {} {} of object {}, edge {} {} of object {}", e.vertices[0],
                                  e.vertices[1], a, g.vertices[0], g.vertices[1], b);
        return;
      }
    }
  }

  void look(const Features& pair, const double* toi, Answer answer) {
    found_ += toi != nullptr;
    const std::string wrong = toi == nullptr ? missed(pair) : reported(pair, *toi, answer);
    const CcdResult narrow = pair.kind == Kind::VertexFace ? vertex_face_ccd(pair.x0, pair.x1, ccd_)
                                                           : edge_edge_ccd(pair.x0, pair.x1, ccd_);
    if (!wrong.empty()) {
      complaint_ = wrong;
    } else if (toi == nullptr && narrow.answer == Answer::Undecided) {
      // It may be left out where something else proves it apart (docs/soundness.md, promise 4).
      ++tally_.asked;
      if (comes_within(pair, ccd_.thickness))
        complaint_ = "missed: a pair that the narrow phase does not decide";
    } else if (narrow.answer != answer ||
               (toi != nullptr && std::memcmp(&narrow.toi, toi, sizeof *toi) != 0)) {
      complaint_ = fmt::format("the answer is {}, the narrow phase's {} at {:a}", int(answer),
                               int(narrow.answer), narrow.toi);
    }
    if (!complaint_.empty()) complaint_.append("\n").append(describe(pair));
  }

  bool may_ask() {
    const int most = ccd_.thickness == 0 ? kMaxExact : kMaxApproaches;
    if (exact_ >= most || rng_() % 4 == 0) return false;
    ++exact_;
    ++tally_.asked;
    return true;
  }

  std::string missed(const Features& pair) {
    if (surely_beyond(pair, ccd_.thickness) || !may_ask()) return {};
    return comes_within(pair, ccd_.thickness)
               ? "missed: a pair comes within the thickness and is not reported"
               : "";
  }

  std::string reported(const Features& pair, double toi, Answer answer) {
    if (!(toi >= 0 && toi <= 1)) return fmt::format("the time {} is not in [0,1]", toi);
    if (answer == Answer::Undecided) return {};
    if (rng_() % 16 != 0) return {};
    if (surely_beyond(pair, bound_)) return "a pair is reported that stays beyond thickness and tolerance";
    if (checked_++ >= 2) return {};
    ++tally_.asked;
    if (!oracle::within_distance(pair.kind, pair.x0, pair.x1, toi,
                                 oracle::Rational(ccd_.thickness) + oracle::Rational(ccd_.tolerance))) {
      return fmt::format("a hit is beyond thickness and tolerance at its time {:a}", toi);
    }
    if (ccd_.thickness == 0 && toi > 0 && oracle::touches(pair.kind, pair.x0, pair.x1, {toi, true}))
      return fmt::format("late: the pair touches before {:a}", toi);
    return {};
  }

  const Case& case_;
  const Step& step_;
  const StepResult& answer_;
  std::mt19937_64& rng_;
  Tally& tally_;
  CcdSettings ccd_;
  double bound_;
  std::vector<std::vector<Feature>> vertices_, faces_, edges_;
  std::string complaint_;
  std::size_t found_ = 0;
  int exact_ = 0, checked_ = 0;
};

// ---- Poses

using Real = long double;
using Direction = Eigen::Matrix<Real, 3, 1>;

Direction direction_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

// A plane between two sets of points, with room for its rounding.
bool plane_between(const Direction& n, std::span<const Direction> a, std::span<const Direction> b,
                   Real size) {
  Real low_a = n.dot(a[0]), high_a = low_a, low_b = n.dot(b[0]), high_b = low_b;
  for (const Direction& p : a) {
    low_a = std::min(low_a, n.dot(p));
    high_a = std::max(high_a, n.dot(p));
  }
  for (const Direction& p : b) {
    low_b = std::min(low_b, n.dot(p));
    high_b = std::max(high_b, n.dot(p));
  }
  const Real room = 0x1p-48L * n.cwiseAbs().maxCoeff() * size;
  return low_b - high_a > room || low_a - high_b > room;
}

bool surely_apart(std::span<const Vec3> a, std::span<const Vec3> b) {
  std::vector<Direction> p, q, sides[2], axes = {Direction::UnitX(), Direction::UnitY(), Direction::UnitZ()};
  Real size = 0;
  for (const Vec3& x : a) p.push_back(direction_of(x) - direction_of(a[0]));
  for (const Vec3& x : b) q.push_back(direction_of(x) - direction_of(a[0]));
  for (const auto* set : {&p, &q}) {
    for (std::size_t k = 0; k < set->size(); ++k) {
      size = std::max(size, (*set)[k].cwiseAbs().maxCoeff());
      sides[set == &q].push_back((*set)[(k + 1) % set->size()] - (*set)[k]);
    }
  }
  for (const auto& own : sides) axes.push_back(own[0].cross(own[1 % own.size()]));
  for (const Direction& e : sides[0]) {
    for (const Direction& g : sides[1]) axes.push_back(e.cross(g));
  }
  for (int k = 0; k < 2; ++k) {
    const Direction normal = axes[3 + k];
    for (const Direction& e : sides[k]) axes.push_back(normal.cross(e));
  }
  return std::any_of(axes.begin(), axes.end(),
                     [&](const Direction& n) { return plane_between(n, p, q, size); });
}

std::vector<Vec3> corners(const Triangle& t, std::span<const double> x) {
  return {point(x, t[0]), point(x, t[1]), point(x, t[2])};
}

bool has(const Triangle& t, Index v) { return v == t[0] || v == t[1] || v == t[2]; }

// Neighbors of which a look says that they do not cross.
bool plainly_clear(const Triangle& a, const Triangle& b, std::span<const double> x) {
  std::vector<Index> common, only_a, only_b;
  for (const Index v : a) (has(b, v) ? common : only_a).push_back(v);
  for (const Index v : b) {
    if (!has(a, v)) only_b.push_back(v);
  }
  if (common.size() == 1 && only_a.size() == 2 && only_b.size() == 2) {
    const std::array<Vec3, 2> far_a = {point(x, only_a[0]), point(x, only_a[1])},
                              far_b = {point(x, only_b[0]), point(x, only_b[1])};
    return surely_apart(far_a, corners(b, x)) && surely_apart(far_b, corners(a, x));
  }
  if (common.size() != 2 || only_a.size() != 1 || only_b.size() != 1 || common[0] == common[1]) return false;
  const auto at = [&](Index v) { return direction_of(point(x, v)); };
  const Direction side = at(common[1]) - at(common[0]), c = at(only_a[0]) - at(common[0]),
                  d = at(only_b[0]) - at(common[0]);
  const Direction across_c = side.cross(c), across_d = side.cross(d);
  const Real size = side.cwiseAbs().maxCoeff(),
             all = size * c.cwiseAbs().maxCoeff() * size * d.cwiseAbs().maxCoeff();
  return across_c.dot(across_d) < -0x1p-46L * all ||
         across_c.cross(across_d).cwiseAbs().maxCoeff() > 0x1p-46L * all;
}

}  // namespace

std::vector<Edge> edges_of(const Object& object) {
  std::set<Edge> edges;
  for (const Triangle& t : object.triangles) {
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      if (low != high) edges.insert({low, high});
    }
  }
  return {edges.begin(), edges.end()};
}

std::string check_step(const Case& c, const Step& step, const StepResult& answer, std::mt19937_64& rng,
                       Tally& tally) {
  return StepCheck(c, step, answer, rng, tally).run();
}

bool triangles_cross(const Triangle& a, const Triangle& b, std::span<const double> x, Tally& tally) {
  if (!std::any_of(a.begin(), a.end(), [&](Index v) { return has(b, v); }))
    return triangles_meet(corners(a, x), corners(b, x), tally);
  if (plainly_clear(a, b, x)) return false;
  ++tally.asked;
  return oracle::triangles_cross(a, b, x);
}

bool triangles_meet(std::span<const Vec3> a, std::span<const Vec3> b, Tally& tally) {
  if (surely_apart(a, b)) return false;
  ++tally.asked;
  return oracle::hulls_intersect(a, b);
}

std::string check_pose(const Case& c, const Poses& x, const StepSettings& settings,
                       const StaticResult& answer, Tally& tally) {
  std::set<oracle::PairKey> reported;
  for (const TriangleCrossing& crossing : answer.crossings) reported.insert(oracle::key(crossing));
  if (reported.size() != answer.crossings.size()) return "a crossing is reported twice";
  std::size_t seen = 0;
  for (Index a = 0; a < c.objects.size(); ++a) {
    for (Index b = a; b < c.objects.size(); ++b) {
      if (!(a == b ? settings.within : settings.between)) continue;
      const auto faces_a = features(c.objects[a].triangles, x[a], x[a]),
                 faces_b = features(c.objects[b].triangles, x[b], x[b]);
      for (Index i = 0; i < faces_a.size(); ++i) {
        for (Index k = a == b ? i + 1 : 0; k < faces_b.size(); ++k) {
          const bool found = reported.contains({a, i, b, k, 0, 0});
          seen += found;
          if (!found && boxes_beyond(faces_a[i], faces_b[k], 0)) continue;
          const Triangle &s = c.objects[a].triangles[i], &t = c.objects[b].triangles[k];
          const bool cross = a == b ? triangles_cross(s, t, x[a], tally)
                                    : triangles_meet(corners(s, x[a]), corners(t, x[b]), tally);
          if (cross != found) {
            return fmt::format(
                "triangle {} of object {} and triangle {} of object {} {} and are {} as crossing", i, a, k, b,
                cross ? "cross" : "do not cross", found ? "reported" : "not reported");
          }
        }
      }
    }
  }
  return seen == reported.size() ? "" : "a crossing is reported of triangles that are not asked for";
}

}  // namespace foldproof::adversary
