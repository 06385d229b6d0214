/// Topology: the triangles that all frames of a motion share.
#pragma once

#include <vector>

#include "foldproof/base.h"

namespace foldproof {

/// Three vertex ids, in the order the user gave them.
using Triangle = std::array<Index, 3>;
/// Two vertex ids.
using Edge = std::array<Index, 2>;

/// What a triangle of a topology stands for. Faces meet all others. Of lines and points, those pairs of
/// features are tested that suffice: two edges, a vertex and a face, a point and a line, two points
/// (docs/soundness.md, V2). Lines and points of one topology that have a vertex in common never cross.
enum class Element : std::uint8_t { Face, Line, Point };

/// Triangles over `vertex_count` vertices, with their edges. Immutable once made. Lines and points that
/// belong to no face are triangles, too: a line is (a, b, b), a point is (p, p, p).
///
/// Any triangle soup is valid: open borders, non-manifold edges, duplicate triangles, several components,
/// vertices in no triangle. A triangle that names a vertex twice is the segment or point that it degenerates
/// to.
class Topology {
 public:
  /// Edges, up to three per triangle, must fit an Index.
  static constexpr Index kMaxTriangles = kNoIndex / 3 - 1;

  /// Error when a triangle names a vertex >= vertex_count, or there are no triangles, or more than
  /// kMaxTriangles.
  /// Cost: one pass; a vertex with many edges sorts them.
  static Result<Topology> make(Index vertex_count, std::vector<Triangle> faces);
  /// With lines, which name two different vertices in either order, and points. The triangles are the faces,
  /// then the lines, then the points, each in the given order; they count towards kMaxTriangles. A point
  /// on a face or a line is an error: it would meet nothing that these do not meet.
  static Result<Topology> make(Index vertex_count, std::vector<Triangle> faces, std::span<const Edge> lines,
                               std::span<const Index> points);

  Index vertex_count() const { return vertex_count_; }
  std::span<const Triangle> triangles() const { return triangles_; }
  /// How many of the triangles are faces; they come first. Then there are line_count() lines, then points.
  Index face_count() const { return face_count_; }
  Index line_count() const { return line_count_; }
  Index point_count() const { return static_cast<Index>(triangles_.size()) - face_count_ - line_count_; }
  std::span<const Triangle> faces() const { return triangles().first(face_count_); }
  std::vector<Edge> lines() const;
  std::vector<Index> points() const;
  Element element(Index triangle) const {
    if (triangle < face_count_) return Element::Face;
    return triangle < face_count_ + line_count_ ? Element::Line : Element::Point;
  }

  /// Every undirected edge once, the smaller vertex first, in lexicographic order.
  std::span<const Edge> edges() const { return edges_; }

  /// Per triangle, the ids of its edges (0,1), (1,2), (2,0); kNoIndex where both ends are the same vertex.
  std::span<const std::array<Index, 3>> triangle_edges() const { return triangle_edges_; }

  /// Same vertex count and the same faces, lines and points in the same order.
  bool operator==(const Topology& other) const {
    return vertex_count_ == other.vertex_count_ && face_count_ == other.face_count_ &&
           line_count_ == other.line_count_ && triangles_ == other.triangles_;
  }

 private:
  void find_edges();

  Index vertex_count_ = 0, face_count_ = 0, line_count_ = 0;
  std::vector<Triangle> triangles_;
  std::vector<Edge> edges_;
  std::vector<std::array<Index, 3>> triangle_edges_;
};

/// True when two triangles name a common vertex.
bool share_vertex(const Triangle& a, const Triangle& b);
/// Whether two triangles of one topology may cross in a pose: all but lines and points with a common vertex.
bool may_cross(const Topology& topology, Index a, Index b);

}  // namespace foldproof
