/// Repairs motions from files and keeps the result until it is written.
#pragma once

#include "foldproof/repair.h"
#include "report/report.h"

namespace foldproof {

struct RepairRequest {
  /// Thickness, frames, ignored pairs, parts and models are used. Training poses of the models are where the
  /// repair may start (RepairSettings::poses).
  CheckSettings check;
  /// Its thickness is not used.
  RepairSettings repair;
  std::vector<std::string> fixed;  ///< Objects and parts that may not move, by name.
  std::vector<std::string> only;   ///< Those that may; empty: all but the fixed ones.
  /// Pairs of objects or parts, by name: only their contacts are repaired, in place of
  /// RepairSettings::chosen.
  std::vector<std::array<std::string, 2>> between = {};
  /// Per object, vertices that may not move, besides; empty: none.
  std::vector<std::vector<Index>> fixed_vertices = {};

  /// Whether something may not move.
  bool fixes() const { return !fixed.empty() || !only.empty() || !fixed_vertices.empty(); }
};

/// Whether a contact is of the group (contact_groups.h) of this one, the worst of it.
std::function<bool(const Contact&)> in_group_of(const Contact& worst);

/// The objects of which something may move. Error: a name that is neither an object's nor a part's.
Result<std::vector<Index>> movable_objects(Motions motions, const RepairRequest& request);

class RepairedMotions {
 public:
  RepairReport report;         ///< Times are numbers of the input's frames.
  std::vector<Index> movable;  ///< The objects of which something may move.
  /// RepairSettings::chosen, of contacts of the motions; null: all are.
  std::function<bool(const Contact&)> chosen;

  /// An object's motion, read from a temporary file. Precondition: report.written.
  std::unique_ptr<Motion> motion(Index object) const;

 private:
  friend Result<RepairedMotions> repair_motions(Motions motions, const RepairRequest& request);
  struct Store;
  std::shared_ptr<Store> store_;
};

/// Error: what repair returns; a range that selects no frame, or leaves some out between others; a name that
/// is neither an object's nor a part's; a model of another mesh, or one that has learned no shapes.
Result<RepairedMotions> repair_motions(Motions motions, const RepairRequest& request);

}  // namespace foldproof
