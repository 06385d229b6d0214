/// Stores the answers of a check in temporary files.
#pragma once

#include <mutex>
#include <optional>

#include "io/spool.h"
#include "report/report.h"

namespace foldproof {

/// The totals of a step. A step of a static check is a pose.
struct StepRecord {
  StepIndex index;
  CollisionCounts collisions;
  std::uint64_t listed = 0;  ///< Collisions that the answer lists.
  double earliest_toi = 1, tolerance = 0;
  Work work;
  ReasonCounts leaf_pairs{};
  StageTimes milliseconds;
  /// Triangles that cross or are inside at the step's begin and its end. None: not known.
  std::array<std::optional<std::uint64_t>, 2> inside{};
};

/// Makes the records of steps, which come in order.
class StepRecorder {
 public:
  explicit StepRecorder(Motions motions) : motions_(motions) {}
  /// The first frame, before all steps.
  void start(const CheckedStep& pose) { inside_ = inside_of(pose); }
  StepRecord add(const CheckedStep& step);
  /// Per object and triangle of the last step: 1 if it meets another in it, 2 if it crosses or is inside at
  /// its begin, 4 at its end, added.
  const std::vector<std::vector<std::uint8_t>>& marks() const { return marks_; }

 private:
  using Inside = std::optional<std::vector<std::vector<std::uint8_t>>>;  // per object; none: not known
  Inside inside_of(const CheckedStep& step) const;

  Motions motions_;
  Inside inside_;  // at the end of the last step
  std::vector<std::vector<std::uint8_t>> marks_;
};

/// The totals of the first frame.
struct StartRecord {
  Index frame = 0;
  std::uint64_t crossings = 0;  ///< Pairs of triangles.
  std::uint64_t listed = 0;     ///< Crossings that the answer lists.
  StageTimes milliseconds;
};

StartRecord start_of(const CheckedStep& pose);

enum class PairKind : std::uint8_t { VertexFace, EdgeEdge, Triangles };

/// Two features that collide, or two triangles that cross in a pose, and the point where they meet.
struct ContactPoint {
  double toi = 0;                 ///< 0 for triangles.
  std::array<double, 3> point{};  ///< Mesh units.
  Index object_a = 0, object_b = 0;
  std::array<Index, 2> a{}, b{};  ///< Vertices of edges; else the vertex, face or triangle in [0].
  PairKind kind = PairKind::EdgeEdge;
  Answer answer = Answer::Hit;
};

/// The answer for a triangle in a step.
struct FaceRecord {
  std::uint8_t marks;  ///< StepRecorder::marks().
  std::uint8_t reason;
  std::int8_t level;
  std::uint8_t margin;  ///< 0 to 255 for 0 to 1.
};

/// An axis-aligned box, mesh units.
struct Bounds {
  std::array<double, 3> low{}, high{};
};

/// One thread adds steps while any number of threads read those already added.
class StepStore {
 public:
  static Result<std::unique_ptr<StepStore>> open(Motions motions);

  /// Call it at most once, before all steps. Error: the temporary file cannot be written.
  Result<void> start(const CheckedStep& pose);
  /// Nothing until start() has been called.
  std::optional<StartRecord> started() const;
  // Preconditions: started(). Error: the temporary file cannot be read.
  /// Sorted by ids; fewer than `limit` at the end.
  Result<std::vector<ContactPoint>> crossings(std::uint64_t offset, std::uint64_t limit) const;

  /// Steps come in order. Error: the temporary file cannot be written.
  Result<void> add(const CheckedStep& step);
  std::uint64_t count() const { return count_.load(std::memory_order_acquire); }

  // Preconditions: number < count(). Error: the temporary file cannot be read.
  Result<StepRecord> record(std::uint64_t number) const;
  /// The bounds of all objects at the end of a step.
  Result<Bounds> bounds(std::uint64_t number) const;
  /// Sorted by time of impact, then vertex-face first, then by ids; fewer than `limit` at the end.
  Result<std::vector<ContactPoint>> contacts(std::uint64_t number, std::uint64_t offset,
                                             std::uint64_t limit) const;
  /// One per triangle.
  Result<std::vector<FaceRecord>> faces(std::uint64_t number, Index object) const;

 private:
  struct Entry {
    StepRecord record;
    std::uint64_t contacts_at, faces_at;  // bytes in details_
    Bounds bounds;                        // at its end
  };
  StepStore(Motions motions, io::Spool entries, io::Spool details);
  Result<void> append(std::span<const char> bytes);
  Result<Entry> entry(std::uint64_t number) const;

  Motions motions_;
  std::vector<std::uint64_t> first_face_;  // per object, then the total
  io::Spool entries_, details_;
  std::uint64_t details_size_ = 0;
  std::atomic<std::uint64_t> count_{0};
  StepRecorder recorder_;
  StartRecord start_;  // valid once started_; its crossings are at 0 in details_
  std::atomic<bool> started_{false};
};

}  // namespace foldproof
