/// All objects as one mesh, for pictures.
#pragma once

#include "report/report.h"

namespace foldproof {

struct JoinedMesh {
  Topology topology;
  std::vector<std::size_t> first_vertex, first_face;  ///< Per object.

  /// Fills `out` with the pose at `t` of the step.
  void pose(const CheckedStep& step, double t, std::vector<double>& out) const;
};

/// Per face of the joined mesh, 1 when it collides in the step.
void mark_faces(Motions motions, const CheckedStep& step, std::vector<std::uint8_t>& out);

/// The contacts of the joined mesh's faces in a frame. Empty where they are not looked for.
struct ContactMarks {
  /// The contact in which the face crosses or is inside, 0 for none; all -1 where that is not known.
  std::vector<std::int32_t> number;
  std::vector<float> depth;  ///< The contact's depth in this frame, 0 where it has none.

  /// Marks the faces as of the step's end, if there are contacts.
  void update(const JoinedMesh& joined, const CheckedStep& step);
};

/// Error, which names `option`: they are too large together.
Result<JoinedMesh> join(Motions motions, const char* option);

}  // namespace foldproof
