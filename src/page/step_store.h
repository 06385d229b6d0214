/// The answers of a check, in a temporary file: memory holds none of them.
#pragma once

#include <mutex>
#include <optional>

#include "io/spool.h"
#include "report/report.h"

namespace foldproof {

/// What is known of a step as a whole.
struct StepRecord {
  StepPlace place;
  CollisionCounts collisions;
  std::uint64_t listed = 0;  ///< Of them, those that the answer lists.
  double earliest_toi = 1, tolerance = 0;
  Work work;
  ReasonCounts leaf_pairs{};
  StageTimes milliseconds;
};

StepRecord record_of(const CheckedStep& step);

/// What is known of the first frame as a whole.
struct StartRecord {
  Index frame = 0;
  std::uint64_t crossings = 0;  ///< Pairs of triangles.
  StageTimes milliseconds;
};

/// Two triangles that cross in the first frame, and where.
struct StartCrossing {
  std::array<double, 3> point{};  ///< Mesh units.
  TriangleCrossing triangles;
};

/// A collision and where it happens.
struct Contact {
  double toi = 0;
  std::array<double, 3> point{};  ///< Mesh units.
  Index object_a = 0, object_b = 0;
  std::array<Index, 2> a{}, b{};  ///< Vertex-face: the vertex and the face, then 0.
  bool vertex_face = false;
  Answer answer = Answer::Hit;
};

/// What is known of a triangle in a step.
struct FaceRecord {
  std::uint8_t colliding;  ///< 0 or 1.
  std::uint8_t reason;
  std::int8_t level;
  std::uint8_t margin;  ///< 0 to 255 for 0 to 1.
};

/// One thread adds steps while any number read those that have been added.
class StepStore {
 public:
  static Result<std::unique_ptr<StepStore>> open(Motions motions);

  /// At most once, before all steps. Error: the temporary file cannot take it.
  Result<void> start(const CheckedStep& pose);
  /// Nothing until then.
  std::optional<StartRecord> started() const;
  // Preconditions: started(). Error: the temporary file cannot be read.
  /// Sorted by ids. Fewer than `limit` at the end.
  Result<std::vector<StartCrossing>> crossings(std::uint64_t offset, std::uint64_t limit) const;
  /// One per triangle: 1 when it crosses another.
  Result<std::vector<std::uint8_t>> crossing_faces(Index object) const;

  /// Steps come in order. Error: the temporary file cannot take it.
  Result<void> add(const CheckedStep& step);
  std::uint64_t count() const { return count_.load(std::memory_order_acquire); }

  // Preconditions: number < count(). Error: the temporary file cannot be read.
  Result<StepRecord> record(std::uint64_t number) const;
  /// By time of impact; at the same time vertex-face first, each sorted by ids. Fewer than `limit` at the
  /// end.
  Result<std::vector<Contact>> contacts(std::uint64_t number, std::uint64_t offset,
                                        std::uint64_t limit) const;
  /// One per triangle.
  Result<std::vector<FaceRecord>> faces(std::uint64_t number, Index object) const;

 private:
  struct Entry {
    StepRecord record;
    std::uint64_t contacts_at, faces_at;  // bytes in details_
  };
  StepStore(Motions motions, io::Spool entries, io::Spool details);
  Result<void> append(std::span<const char> bytes);
  Result<Entry> entry(std::uint64_t number) const;

  Motions motions_;
  std::vector<std::uint64_t> first_face_;  // per object, and their sum
  io::Spool entries_, details_;
  std::uint64_t details_size_ = 0;
  std::atomic<std::uint64_t> count_{0};
  StartRecord start_;                 // once started_
  std::uint64_t start_faces_at_ = 0;  // its crossings lie at 0
  std::atomic<bool> started_{false};
};

}  // namespace foldproof
