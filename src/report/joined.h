/// All objects as one mesh, for pictures.
#pragma once

#include "report/report.h"

namespace foldproof {

struct JoinedMesh {
  Topology topology;                      ///< The faces of all objects, then their lines, then their points.
  std::vector<std::size_t> first_vertex;  ///< Per object.
  /// Per object, where its first face, line and point are, and how many faces and lines it has.
  struct Place {
    std::array<std::size_t, 3> first;
    std::size_t faces, lines;
  };
  std::vector<Place> places;

  /// A triangle of an object.
  std::size_t triangle(Index object, std::size_t own) const {
    const auto& [first, faces, lines] = places[object];
    if (own < faces) return first[0] + own;
    return own < faces + lines ? first[1] + own - faces : first[2] + own - faces - lines;
  }
  /// Puts values per triangle of an object to their places in `out`, which has all.
  template <class Values, class T>
  void put(Index object, const Values& values, std::vector<T>& out) const {
    out.resize(topology.triangles().size());
    for (std::size_t own = 0; own < values.size(); ++own) out[triangle(object, own)] = values[own];
  }

  /// Fills `out` with the pose at `t` of the step.
  void pose(const CheckedStep& step, double t, std::vector<double>& out) const;
};

/// Per face of the joined mesh, 1 when it meets another during the step; all 0 for a pose.
void mark_meeting(const JoinedMesh& joined, Motions motions, const CheckedStep& step,
                  std::vector<std::uint8_t>& out);

/// What goes through what in a frame, per face of the joined mesh.
struct InsideMarks {
  std::vector<std::uint8_t> inside;  ///< 1 where the face crosses or is inside; 0 where that is not known.
  /// The contact in which it does, 0 for none; all -1 where that is not known. Empty: contacts are not looked
  /// for.
  std::vector<std::int32_t> number;
  std::vector<float> depth;  ///< The contact's depth in this frame, 0 where it has none.
  double deepest = 0;        ///< The largest of them.
  std::uint64_t count = 0;   ///< Of the faces that are inside.

  /// Marks the faces as of the step's end.
  void update(const JoinedMesh& joined, Motions motions, const CheckedStep& step);
};

/// Error, which names `option`: they are too large together.
Result<JoinedMesh> join(Motions motions, const char* option);

}  // namespace foldproof
