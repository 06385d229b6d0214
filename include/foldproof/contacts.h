/// Contacts: what goes through what, where, from when to when, how deep. Made from the answers of a check.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "foldproof/check.h"

namespace foldproof {

/// What a contact is in one frame in which triangles cross. Only faces have curves, areas and depth.
struct ContactFrame {
  double time = 0;              ///< The frame's time, as the caller gave it.
  std::uint64_t crossings = 0;  ///< Pairs of triangles that cross.
  std::uint64_t triangles = 0;  ///< Triangles that cross or are inside, on both sides.
  double curve_length = 0;      ///< Of the curves in which the surfaces cross, mesh units.
  bool closed = false;          ///< Whether all of these curves are closed.
  /// Per side: the area inside the other surface, mesh units squared. None: the side has no region of its
  /// own, as the curves do not divide it, the other side is open, or both are one surface.
  std::array<std::optional<double>, 2> area;
  /// The surfaces meet, and neither is inside the other: beyond rounding, nothing crosses. No depth.
  bool touching = false;
  /// The largest distance of what is inside to the nearest outside, mesh units. None: it only touches, lines
  /// or points pierce faces, or it cannot be told what is inside.
  std::optional<double> depth;
  /// Both surfaces are open where they cross, so that neither has an inside: they pass through each other,
  /// and `depth` is how far the shorter tip reaches beyond the other surface, at least.
  bool at_least = false;

  /// How bad it is, as a depth in mesh units: the depth; without one, a twentieth of curve_length, which is
  /// as deep as contacts with such curves usually are (docs/contacts.md); 0 where it only touches.
  double severity() const { return touching ? 0 : depth.value_or(curve_length / 20); }
};

/// One contact: colliding features and crossing triangles that are connected on both surfaces and in time.
struct Contact {
  /// Counts from 1 in the order in which contacts begin. Contacts that join keep the smallest of their
  /// numbers.
  Index number = 0;
  std::vector<Index> joined;  ///< Numbers of contacts that joined this one, ascending.

  /// One of the two surfaces.
  struct Side {
    Index object = 0;
    Index part = kNoIndex;  ///< The part of most of its triangles; kNoIndex where there are no parts.
    /// The triangles that cross or are inside in the worst frame, ascending.
    std::vector<Index> triangles;
    std::vector<Index> inside;  ///< Those of them that lie entirely inside, ascending.
  };
  /// Of two objects, the smaller is first; within one, the smaller part, or that of the smallest triangle.
  std::array<Side, 2> sides;
  bool within() const { return sides[0].object == sides[1].object; }
  /// The two sides are one piece of surface, folded onto itself.
  bool folded = false;

  /// A line or a point goes through faces, and no two faces meet.
  bool pierces = false;
  bool from_start = false;  ///< It was there when the motion began.
  bool healed = false;      ///< It ended before the motion did.
  double first_time = 0;    ///< First impact; the motion's begin with from_start.
  double last_time = 0;     ///< The last frame in which it crosses, or the last impact, whichever is later.
  std::uint64_t pairs = 0;  ///< Colliding pairs of features, of those listed, over all steps.

  /// The frames in which triangles cross, ascending. Empty: surfaces touch between frames only.
  std::vector<ContactFrame> frames;
  /// Index of the worst frame: the one with the largest severity; of those, one that crosses.
  std::size_t worst = 0;
  /// Where it is, in the worst frame: the deepest point, or the point of the curves nearest to their middle;
  /// without frames the place of first impact. It lies on one of the surfaces.
  Vec3 point = Vec3::Zero();
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< Box of what takes part, in the worst frame.
  /// From the other surface to the deepest point, or across both surfaces; a unit vector, or zero where there
  /// is none.
  Vec3 normal = Vec3::Zero();
  /// Curves in the worst frame, as polylines; a closed one repeats its first point.
  std::vector<std::vector<Vec3>> curves;

  /// In the worst frame.
  std::optional<double> depth() const {
    return frames.empty() ? std::optional<double>() : frames[worst].depth;
  }
  /// The depth is a lower bound: both surfaces are open, and pass through each other.
  bool at_least() const { return !frames.empty() && frames[worst].at_least; }
  /// Nothing of it ever crosses, beyond rounding, in any frame. Without frames, it touches in between; where
  /// it is not known what crosses (ContactFinder::is_known), perhaps more.
  bool touching() const { return frames.empty() || frames[worst].touching; }
};

/// Whether `a` is worse than `b`: more severe in its worst frame, where one that crosses is worse than one
/// that only touches; else with more pairs; else first.
bool is_worse(const Contact& a, const Contact& b);

/// A number per triangle of an object: which part of it the triangle belongs to. Empty: no parts.
using Parts = std::vector<std::span<const Index>>;

/// Joins the answers of a check into contacts, as they come. Which triangles cross in a frame follows exactly
/// from those that cross in the frame before and from the step between (docs/contacts.md), so no pose needs a
/// query but the first. Memory is bounded by the meshes, one step and the contacts.
class ContactFinder {
 public:
  /// `topologies`: one per object, which the finder keeps a reference to. `parts`: one per object, or empty.
  /// `filter`: the checker's, null for none. Precondition: topologies and parts outlive the finder. Error:
  /// more than 2^32 - 2 vertices or triangles in all.
  static Result<ContactFinder> make(std::vector<const Topology*> topologies, Parts parts = {},
                                    std::shared_ptr<const PairFilter> filter = nullptr);
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  /// The first frame, with all triangles that cross in it; before any step. Without this call, or when not
  /// all of them are listed, what crosses is not known, and contacts have no frames, until a step says it.
  void start(double time, Positions x, const StaticResult& crossings);
  /// The next step, from the time of the last call (or `begin`, without one) to `end`; the same time only
  /// where nothing moves, as with a single pose. `step`: its answer, without declared_free and
  /// earliest_only. `crossings`: what crosses at its end, where that cannot follow from what is known: when
  /// it was not known before, or not all pairs of the step are listed.
  void step(double begin, double end, Positions x0, Positions x1, const StepResult& step,
            const StaticResult* crossings = nullptr);
  /// Whether it is known which triangles cross in the last frame.
  bool is_known() const;
  /// The pairs of triangles that cross in the last frame, sorted by ids.
  std::span<const TriangleCrossing> crossings() const;

  /// The contact of each pair of the last start or step: of its crossings before the call, vertex_face and
  /// edge_edge pairs, in their order; of crossings() now.
  std::span<const Index> vertex_face_contacts() const;
  std::span<const Index> edge_edge_contacts() const;
  std::span<const Index> crossing_contacts() const;
  /// A triangle that lies entirely inside the other surface of a contact, in the last frame.
  struct Inside {
    Index object, triangle;
    Index contact;
  };
  std::span<const Inside> inside() const;
  /// The depth of an open contact in the last frame; none where it does not cross or has no region.
  std::optional<double> depth_now(Index number) const;
  /// The smallest number of the contacts that this one has joined so far.
  Index joined_number(Index number) const;

  /// How many contacts have not ended.
  std::size_t open_count() const;
  /// Contacts that have ended since the last call, by number.
  std::vector<Contact> take_ended();
  /// The motion is over: ends all contacts. Returns those not yet taken, by number.
  std::vector<Contact> finish();

 private:
  struct Impl;
  explicit ContactFinder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// A frame of a motion: its time and the positions of all objects, which are read until the next is asked
/// for.
struct MotionFrame {
  double time = 0;
  Positions x;
};

/// Checks a motion frame by frame and passes each contact to `ended` when it has ended, those that last until
/// the end of the motion then. `next` returns the frames in order and none after the last. Where a step or a
/// pose has more pairs than settings.max_listed, those listed are joined. Memory: the meshes, two frames, one
/// answer and the contacts that have not ended. Error: what `next` or StepChecker returns; declared_free and
/// earliest_only, whose answers are not complete; those of ContactFinder::make. `filter`: as of StepChecker.
Result<void> find_contacts(const std::vector<Object>& objects,
                           const std::function<Result<std::optional<MotionFrame>>()>& next,
                           const std::function<void(Contact)>& ended, const StepSettings& settings = {},
                           Parts parts = {}, std::shared_ptr<const PairFilter> filter = nullptr);

}  // namespace foldproof
