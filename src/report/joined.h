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

/// Per face of the joined mesh: the contact in whose frame it crosses or is inside, 0 for none, and the
/// contact's depth in that frame, 0 where it has none.
void mark_contacts(const JoinedMesh& joined, const ContactFinder& contacts, std::vector<std::int32_t>& number,
                   std::vector<float>& depth);

/// Error, which names `option`: they are too large together.
Result<JoinedMesh> join(Motions motions, const char* option);

}  // namespace foldproof
