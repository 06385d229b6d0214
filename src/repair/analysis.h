/// What touches in a motion: which frames are free, which ways between them, and where it is bad.
#pragma once

#include <set>
#include <tuple>

#include "foldproof/filters.h"
#include "repair/frame_solver.h"
#include "repair/poses.h"

namespace foldproof::inline internal {

/// Checks a motion frame by frame, in order.
///
/// Contacts are those of all pairs, so that they are what a check finds; whether a frame is free does not
/// depend on what may not move with itself.
class Analysis {
 public:
  /// `keeps_seams`: also where a frame has no crossings.
  Analysis(const RepairScene& scene, Prover& prover, double thickness, bool keeps_seams = false);
  Result<void> add(double time, std::span<const double> x);
  struct Contacts {
    std::vector<Contact> of_movable;   ///< Something that may move takes part.
    std::vector<Contact> among_fixed;  ///< All others.
  };
  /// All contacts of the motion, by number, after its last frame.
  Result<Contacts> finish();

  std::size_t frame_count() const { return frames_.size(); }
  /// Nothing touches in the frame; on the way to it from the frame before.
  bool is_free(std::size_t k) const { return frames_[k].is_free; }
  bool is_way_free(std::size_t k) const { return frames_[k].is_way_free; }
  bool all_free() const;
  /// Numbers of the contacts that cross in the frame; after finish().
  std::set<Index> crossing_contacts(std::size_t k) const;
  /// Pairs of vertices of what touches, at any time, in these contacts, and never in the others that are
  /// given; after finish(). None where a frame has no crossings, unless seams are kept.
  std::vector<std::array<ObjectVertex, 2>> seams(const std::set<Index>& contacts,
                                                 const std::set<Index>& not_in = {}) const;
  std::uint64_t crossings(std::size_t k) const { return frames_[k].crossings; }
  /// Per vertex, whether it or a vertex near it touches something in or next to the frame.
  const std::vector<std::uint8_t>& touched(std::size_t k);

 private:
  struct Seam {
    Index contact;
    std::array<Index, 2> ends;
    bool operator<(const Seam& other) const {
      return std::tie(contact, ends) < std::tie(other.contact, other.ends);
    }
    bool operator==(const Seam&) const = default;
  };
  struct Frame {
    bool is_free = false, is_way_free = false;
    std::uint64_t crossings = 0;
    std::vector<Index> touched;
    std::set<Index> contacts;  // numbers of those that cross
  };
  Result<const StaticResult*> all_crossings(std::span<const double> x);
  Result<const StepResult*> with_fixed(const StepResult& step, std::span<const double> x);
  Result<void> find_contacts(double time, std::span<const double> x, const StepResult* step);
  void note_movable(const StepResult* step);
  void note_seams(const StepResult* step);
  void sort_seams();
  bool moves(std::span<const Index> a, std::span<const Index> b) const;
  template <class Visit>
  void for_touching(const StepResult* step, const Visit& visit) const;
  void touch(Frame& frame, const StepResult& step) const;
  void touch_crossings(Frame& frame) const;

  const RepairScene* scene_;
  Prover* prover_;
  std::optional<Prover> fixed_prover_;  // of what may not move with itself; none where everything may
  double thickness_;
  bool keeps_seams_;
  std::optional<ContactFinder> finder_;
  std::set<Index> movable_contacts_;  // numbers
  bool notes_seams_ = true;
  std::vector<Seam> seams_;  // ascending after finish()
  std::size_t distinct_seams_ = 0;
  StepResult all_pairs_;
  StaticResult all_crossings_;
  std::vector<double> last_;
  std::vector<std::span<const double>> views_, last_views_;
  double last_time_ = 0;
  std::vector<Frame> frames_;
  std::vector<Contact> ended_;
  std::vector<std::uint8_t> mask_;
  std::size_t mask_of_ = kNoIndex;
};

/// Marks what is at most `rings` edges away from what is marked.
void dilate(const RepairScene& scene, std::vector<std::uint8_t>& mask, int rings);

/// A pose without crossings that differs from `x` around its contacts, which are filled in smoothly, more
/// rings around them each time until nothing crosses; none where that fails.
Result<std::optional<std::vector<double>>> untangle(const RepairScene& scene, Prover& prover,
                                                    std::span<const double> x);

}  // namespace foldproof::inline internal
