/// Finds the pose of one frame: near the target, and the straight way to it proven free.
#pragma once

#include <map>

#include "base/try.h"
#include "repair/surface.h"

namespace foldproof::inline internal {

/// What a frame is solved with.
struct FrameProblem {
  std::span<const double> before;  ///< A pose from which the way is to be free; empty: there is none.
  std::span<const double> begin;   ///< A pose to which it is free. Where Newton's method begins.
  std::span<const double> target;
  BarrierRange range;
  std::span<const double> after = {};  ///< A pose to which the way on is to be free, and is; empty: none.
  double accuracy = 1;                 ///< RepairSettings::accuracy.
  bool rough = false;                  ///< Another solve follows, which comes closer to the minimum.
  int iterations = 12;                 ///< Of Newton's method, at most.
  double hopeless = 0;                 ///< Mesh units. It ends where changes stay larger than this; 0: never.
};

struct FrameOutcome {
  bool arrived = false;  ///< What may not move is at the target; else there is no pose.
  bool settled = false;  ///< Newton's method came to its end.
  bool late = false;     ///< More time is needed to get near the target.
  double wanted = 0;     ///< The last change that Newton's method asked for, mesh units.
  int iterations = 0;
};

class FrameSolver {
 public:
  /// `edge`, `falloff`: lengths of the mesh, SceneSize::edge and that of `surface`.
  FrameSolver(const RepairScene& scene, ElasticSurface& surface, NearPairs& pairs, Prover& prover,
              double edge, double falloff, bool single_precision)
      : scene_(&scene),
        surface_(&surface),
        pairs_(&pairs),
        prover_(&prover),
        edge_(edge),
        falloff_(falloff),
        single_precision_(single_precision) {}
  void set_interrupted(std::function<bool()> interrupted) { interrupted_ = std::move(interrupted); }

  /// `x`: a guess, which becomes the pose; the ways are proven free in any case. Error: interrupted.
  Result<FrameOutcome> solve(const FrameProblem& problem, std::vector<double>& x);

  /// ElasticSurface::carry.
  void carry(std::span<const double> from, std::span<const double> to, std::span<double> x) {
    surface_->carry(from, to, x);
  }
  /// Proven.
  Result<bool> is_way_free(std::span<const double> from, std::span<const double> to) {
    return FOLDPROOF_TRY(prover_->check(from, to))->clean();
  }
  /// Pairs that collided on the ways of the last solve, or were set before it, and are near there: the
  /// barrier acts on them. Of the way to the frame, and of that on to the next.
  std::array<std::vector<FeaturePair>, 2> ways() const;
  /// For the next solve.
  void set_ways(std::span<const FeaturePair> before, std::span<const FeaturePair> after);

 private:
  struct Pairs {
    std::vector<NearPair> near;
    std::size_t in_pose = 0;  ///< The first so many; the others are from the way.
  };

  /// A pair that collides on a way.
  struct Collision {
    FeaturePair pair;
    double toi;
  };

  Result<bool> approach(std::vector<double>& z, bool proves);
  Result<bool> prove();
  Result<bool> check_ways(std::span<const double> z, bool first, bool proves);
  CcdResult ccd(const FeaturePair& pair, std::span<const double> from, std::span<const double> to) const;
  void test_known(std::span<const double> from, std::span<const double> to, bool is_after);
  void limit_shares(std::span<const double> z, bool is_after, bool first);
  double share_of(const FeaturePair& pair, std::span<const double> z, double toi, bool first) const;
  void spread(std::span<const Index> from, std::span<const double> x, double unit,
              std::vector<double>& values) const;
  void place(std::span<const double> whole, std::vector<double>& z) const;
  Result<void> begin(const FrameProblem& problem, std::span<const double> guess);
  Result<void> iterate(double stiffness, FrameOutcome& outcome);
  Result<bool> descend(double stiffness);
  Result<void> find_pairs(std::span<const double> x, Pairs& out);
  std::optional<std::pair<FourPoints, double>> on_way(const FeaturePair& pair, bool is_after,
                                                      std::span<const double> x) const;
  void forget_far_ways(std::span<const double> x);
  void add_way_pairs(std::span<const double> x, Pairs& out);
  void release();
  void grow_active(std::span<const NearPair> pairs);
  void start_active();
  bool is_late(std::span<const double> x) const;
  void round(std::span<double> x) const;
  double change(std::span<const double> a, std::span<const double> b) const;

  const RepairScene* scene_;
  ElasticSurface* surface_;
  NearPairs* pairs_;
  Prover* prover_;
  double edge_, falloff_;
  bool single_precision_;
  std::function<bool()> interrupted_;

  const FrameProblem* problem_ = nullptr;
  std::vector<double> y_;       // the pose so far; the way to it is free, as far as pairs are known
  std::vector<double> proven_;  // the last one to which it is proven to be
  bool is_proven_ = false;      // y_ is
  std::vector<double> next_, whole_;
  Pairs pairs_of_y_, pairs_of_next_;
  // To the frame, and on from it: pairs and their ranges; 0 where these are not known.
  std::array<std::map<FeaturePair, double>, 2> ways_;
  std::vector<FeaturePair> may_touch_;
  std::vector<Collision> collisions_;
  bool late_ = false;  // y: see is_late
  // Per vertex: the share of the way; the distance from what is near, in falloffs.
  std::vector<double> share_, along_;
  std::vector<double> limit_;
  double all_share_ = 1;  // of all vertices
  std::vector<std::uint8_t> is_active_;
};

}  // namespace foldproof::inline internal
