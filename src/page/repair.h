/// A repair of the scene, on request.
#pragma once

#include <mutex>

#include "page/scene_data.h"
#include "report/repair_motions.h"

namespace foldproof {

/// What a repair may do.
struct RepairChoice {
  std::vector<Index> fixed = {};                        ///< Objects that may not move,
  std::vector<ScenePart> fixed_parts = {};              ///< parts,
  std::vector<std::vector<Index>> fixed_vertices = {};  ///< and vertices, per object; empty: none.
  std::optional<Contact> contact = {};  ///< The worst of a group: only contacts of that are repaired.
};

class RepairService {
 public:
  struct Context {
    std::function<void(double)> progress;  ///< Called with the share that is done, besides; or empty.
    std::vector<PageFile> files;           ///< For reports.
    std::string command;
  };
  RepairService(const SceneData& scene, Context context) : scene_(scene), context_(std::move(context)) {}

  /// Queues a repair, in place of an earlier one.
  void start(RepairChoice choice);
  /// Ends the repair that is queued or being computed.
  void cancel();
  /// What is known of it.
  Json status() const;
  /// Computes a queued repair; false if there is none.
  bool compute_queued(const std::atomic<bool>& stop);

  /// Positions of an object in the k-th frame of the scene. Error: nothing is repaired.
  Result<std::vector<double>> frame(Index object, Index k) const;
  /// A file of an object that was repaired: GLB of what was glTF, else NPZ. Error: it was not, or cannot be
  /// written.
  Result<std::string> file(Index object) const;
  /// The contacts that remain, then those that were left, with their triangles. Error: nothing is repaired.
  Result<Json> contacts(std::uint64_t offset, std::uint64_t limit) const;
  /// The HTML report of `repair --report`. Error: nothing is repaired, or those of write_repaired_report.
  Result<std::string> report() const;

 private:
  enum class State : std::uint8_t { Idle, Queued, Running, Done, Failed };
  struct Repaired {
    RepairRequest request;
    RepairedMotions motions;
    std::vector<std::string> files;  // names, of the objects that may move
    std::vector<bool> moved;         // whether each of these was
  };
  Result<Repaired> compute(const RepairChoice& choice, const std::atomic<bool>& stop);
  Result<std::vector<bool>> moved(const RepairedMotions& motions) const;
  Result<std::shared_ptr<const Repaired>> done() const;
  Result<std::shared_ptr<const Repaired>> repaired(Index object) const;
  std::string file_name(Index object) const;

  const SceneData& scene_;
  const Context context_;
  std::atomic<bool> cancelled_ = false;
  mutable std::mutex mutex_;  // guards the following
  State state_ = State::Idle;
  double progress_ = 0;
  RepairChoice choice_;
  std::string error_;
  std::shared_ptr<const Repaired> done_;
};

}  // namespace foldproof
