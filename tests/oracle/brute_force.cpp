#include "oracle/brute_force.h"

#include <algorithm>
#include <array>
#include <set>

namespace foldproof::oracle {
namespace {

Vec3 point(std::span<const double> x, Index v) { return {x[3 * v], x[3 * v + 1], x[3 * v + 2]}; }

std::vector<Index> used_vertices(const Topology& topology) {
  std::set<Index> used;
  for (const Triangle& t : topology.triangles()) used.insert(t.begin(), t.end());
  return {used.begin(), used.end()};
}

bool wanted(std::size_t object_a, std::size_t object_b, const StepSettings& settings) {
  return object_a == object_b ? settings.within : settings.between;
}

// Per vertex, whether it is a point and on no face or line.
std::vector<bool> only_points(const Topology& topology) {
  std::vector<bool> is_point(topology.vertex_count(), false);
  for (int pass = 0; pass < 2; ++pass) {
    for (Index t = 0; t < topology.triangles().size(); ++t) {
      const bool point = topology.element(t) == Element::Point;
      if (point != (pass == 0)) continue;
      for (const Index v : topology.triangles()[t]) is_point[v] = point;
    }
  }
  return is_point;
}

// Whether a mesh has faces that name a vertex twice, and the vertex is in a face.
bool may_lack_edges(const Topology& topology, Index vertex) {
  bool in_face = false, thin = false;
  for (Index t = 0; t < topology.triangles().size() && topology.element(t) == Element::Face; ++t) {
    const auto& [a, b, c] = topology.triangles()[t];
    in_face = in_face || vertex == a || vertex == b || vertex == c;
    thin = thin || a == b || b == c || c == a;
  }
  return in_face && thin;
}

// Lines and points meet vertices that are nothing but points, two points once; and vertices of faces that may
// be points or segments themselves.
bool tested(const Scene& scene, const VertexFaceCollision& pair, const std::vector<bool>& is_point) {
  const Topology& topology = scene.topologies[pair.face_object];
  switch (topology.element(pair.face)) {
    case Element::Face:
      return true;
    case Element::Line:
      return is_point[pair.vertex] || may_lack_edges(scene.topologies[pair.vertex_object], pair.vertex);
    case Element::Point:
      break;
  }
  return is_point[pair.vertex] && std::pair(pair.vertex_object, pair.vertex) <
                                      std::pair(pair.face_object, topology.triangles()[pair.face][0]);
}

class StepSweep {
 public:
  StepSweep(const Scene& scene, const StepSettings& settings, double tolerance)
      : scene_(scene), settings_(settings) {
    narrow_.thickness = settings.thickness;
    narrow_.tolerance = tolerance;
    result_.tolerance = tolerance;
    result_.complete = true;
  }

  StepResult run() {
    for (Index a = 0; a < scene_.topologies.size(); ++a) {
      for (Index b = 0; b < scene_.topologies.size(); ++b) {
        if (!wanted(a, b, settings_)) continue;
        vertices_and_faces(a, b);
        if (a <= b) edges_and_edges(a, b);
      }
    }
    keep_earliest();
    result_.vertex_face_count = result_.vertex_face.size();
    result_.edge_edge_count = result_.edge_edge.size();
    return std::move(result_);
  }

 private:
  void vertices_and_faces(Index a, Index b) {
    const auto triangles = scene_.topologies[b].triangles();
    const std::vector<bool> is_point = only_points(scene_.topologies[a]);
    for (const Index v : used_vertices(scene_.topologies[a])) {
      for (Index f = 0; f < triangles.size(); ++f) {
        const Triangle& t = triangles[f];
        if (a == b && (v == t[0] || v == t[1] || v == t[2])) continue;
        VertexFaceCollision pair{a, v, b, f, 1, Answer::Separated};
        if (!tested(scene_, pair, is_point)) continue;
        const PairPoints p = points_of(pair, scene_);
        if (boxes_stay_apart(p, 1)) continue;
        const CcdResult r = vertex_face_ccd(p.x0, p.x1, narrow_);
        if (r.answer == Answer::Separated) continue;
        pair.toi = r.toi;
        pair.answer = r.answer;
        result_.vertex_face.push_back(pair);
      }
    }
  }

  void edges_and_edges(Index a, Index b) {
    const auto edges_a = scene_.topologies[a].edges(), edges_b = scene_.topologies[b].edges();
    for (std::size_t i = 0; i < edges_a.size(); ++i) {
      for (std::size_t j = a == b ? i + 1 : 0; j < edges_b.size(); ++j) {
        const Edge &e = edges_a[i], &g = edges_b[j];
        if (a == b && (e[0] == g[0] || e[0] == g[1] || e[1] == g[0] || e[1] == g[1])) continue;
        EdgeEdgeCollision pair{a, e, b, g, 1, Answer::Separated};
        const PairPoints p = points_of(pair, scene_);
        if (boxes_stay_apart(p, 2)) continue;
        const CcdResult r = edge_edge_ccd(p.x0, p.x1, narrow_);
        if (r.answer == Answer::Separated) continue;
        pair.toi = r.toi;
        pair.answer = r.answer;
        result_.edge_edge.push_back(pair);
      }
    }
  }

  // Whether what the first points sweep and what the others sweep have boxes too far apart for a collision,
  // which saves most of the time. Twice the distance leaves room for rounding.
  bool boxes_stay_apart(const PairPoints& p, int first) const {
    const auto box = [&](int begin, int end) {
      Vec3 low = p.x0[begin], high = low;
      for (int i = begin; i < end; ++i) {
        low = low.cwiseMin(p.x0[i]).cwiseMin(p.x1[i]);
        high = high.cwiseMax(p.x0[i]).cwiseMax(p.x1[i]);
      }
      return std::pair(low, high);
    };
    const auto [low_a, high_a] = box(0, first);
    const auto [low_b, high_b] = box(first, 4);
    const double far = 2 * (narrow_.thickness + narrow_.tolerance);
    return (low_b - high_a).maxCoeff() > far || (low_a - high_b).maxCoeff() > far;
  }

  void keep_earliest() {
    for (const auto& pair : result_.vertex_face)
      result_.earliest_toi = std::min(result_.earliest_toi, pair.toi);
    for (const auto& pair : result_.edge_edge)
      result_.earliest_toi = std::min(result_.earliest_toi, pair.toi);
  }

  const Scene& scene_;
  const StepSettings& settings_;
  CcdSettings narrow_;
  StepResult result_;
};

bool boxes_apart(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  const Vec3 a_lo = a[0].cwiseMin(a[1]).cwiseMin(a[2]), a_hi = a[0].cwiseMax(a[1]).cwiseMax(a[2]);
  const Vec3 b_lo = b[0].cwiseMin(b[1]).cwiseMin(b[2]), b_hi = b[0].cwiseMax(b[1]).cwiseMax(b[2]);
  for (int axis = 0; axis < 3; ++axis) {
    if (a_lo[axis] > b_hi[axis] || b_lo[axis] > a_hi[axis]) return true;
  }
  return false;
}

std::array<Vec3, 3> corners(const Triangle& t, std::span<const double> x) {
  return {point(x, t[0]), point(x, t[1]), point(x, t[2])};
}

// The vertices of a triangle that are (or are not) among those of another, each once.
std::vector<Index> split(const Triangle& t, const Triangle& other, bool shared) {
  std::set<Index> result;
  for (const Index v : t) {
    if ((v == other[0] || v == other[1] || v == other[2]) == shared) result.insert(v);
  }
  return {result.begin(), result.end()};
}

}  // namespace

PairPoints points_of(const VertexFaceCollision& pair, const Scene& scene) {
  const Triangle& t = scene.topologies[pair.face_object].triangles()[pair.face];
  const auto at = [&](const std::vector<std::vector<double>>& x) {
    const std::vector<double>& f = x[pair.face_object];
    return FourPoints{point(x[pair.vertex_object], pair.vertex), point(f, t[0]), point(f, t[1]),
                      point(f, t[2])};
  };
  return {at(scene.x0), at(scene.x1)};
}

PairPoints points_of(const EdgeEdgeCollision& pair, const Scene& scene) {
  const auto at = [&](const std::vector<std::vector<double>>& x) {
    const std::vector<double>&a = x[pair.object_a], &b = x[pair.object_b];
    return FourPoints{point(a, pair.a[0]), point(a, pair.a[1]), point(b, pair.b[0]), point(b, pair.b[1])};
  };
  return {at(scene.x0), at(scene.x1)};
}

StepResult brute_force_step(const Scene& scene, const StepSettings& settings, double tolerance) {
  return StepSweep(scene, settings, tolerance).run();
}

bool triangles_cross(const Triangle& a, const Triangle& b, std::span<const double> x) {
  const std::vector<Index> common = split(a, b, true);
  const std::vector<Index> only_a = split(a, b, false), only_b = split(b, a, false);
  if (common.empty()) {
    const std::array<Vec3, 3> p = corners(a, x), q = corners(b, x);
    return hulls_intersect(p, q);
  }
  // A triangle that names a vertex twice may have none of its own: then it is a side or a corner of the
  // other.
  const bool part_of_other = only_a.empty() != only_b.empty() || (only_a.empty() && common.size() < 3);
  if (part_of_other) return false;
  if (common.size() == 1) {
    // Two proper triangles meet away from their common vertex exactly when the side opposite to it in one
    // meets the other triangle. With degenerate ones the same rule counts a vertex that lies on the common
    // one without being it. A triangle that names a vertex twice has one far vertex for a side.
    const auto far_side_meets = [&](const std::vector<Index>& far, const Triangle& other) {
      std::vector<Vec3> side;
      for (const Index v : far) side.push_back(point(x, v));
      const std::array<Vec3, 3> q = corners(other, x);
      return hulls_intersect(side, q);
    };
    return far_side_meets(only_a, b) || far_side_meets(only_b, a);
  }
  if (common.size() == 2) {
    return meet_beyond_edge(point(x, common[0]), point(x, common[1]), point(x, only_a[0]),
                            point(x, only_b[0]));
  }
  // The same triangle twice: it has everything in common, wherever it is.
  return true;
}

StaticResult brute_force_static(const Scene& scene, const StepSettings& settings) {
  StaticResult result;
  for (Index a = 0; a < scene.topologies.size(); ++a) {
    for (Index b = a; b < scene.topologies.size(); ++b) {
      if (!wanted(a, b, settings)) continue;
      const auto ta = scene.topologies[a].triangles(), tb = scene.topologies[b].triangles();
      for (Index i = 0; i < ta.size(); ++i) {
        for (Index j = a == b ? i + 1 : 0; j < tb.size(); ++j) {
          const std::array<Vec3, 3> p = corners(ta[i], scene.x0[a]), q = corners(tb[j], scene.x0[b]);
          if (boxes_apart(p, q)) continue;
          // Lines and points with a common vertex are neighbors, however they lie.
          const bool face = scene.topologies[a].element(i) == Element::Face ||
                            scene.topologies[b].element(j) == Element::Face;
          if (a == b && !face && !split(ta[i], ta[j], true).empty()) continue;
          const bool cross = a == b ? triangles_cross(ta[i], tb[j], scene.x0[a]) : hulls_intersect(p, q);
          if (cross) result.crossings.push_back({a, i, b, j});
        }
      }
    }
  }
  result.crossing_count = result.crossings.size();
  result.complete = true;
  return result;
}

}  // namespace foldproof::oracle
