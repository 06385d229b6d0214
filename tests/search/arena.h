/// One attack on one certificate: a chart or a plane, positions that may be moved at will as long as it
/// holds, and a pair of features that shall meet.
#pragma once

#include <memory>

#include "certificate/contacts.h"
#include "certificate/patches.h"
#include "certificate/separating_plane.h"

namespace foldproof::search {

using testing::FeaturePair;
using testing::Rng;

/// A certificate, as far as an attacker is concerned.
class Certificate {
 public:
  virtual ~Certificate() = default;
  /// The features it speaks about, by vertices of the attack.
  virtual std::span<const FeaturePair> pairs() const = 0;
  virtual bool holds(std::span<const MovingVertex> vertices, double gap) = 0;
};

/// Whether the certificate is the library's, or one with a mistake, which the search has to find.
enum class Honesty { Real, Planted };

/// A chart's promise about its patch; the vertices are those of the patch, in its order. The planted mistake:
/// it leaves a triangle out.
std::unique_ptr<Certificate> chart_certificate(const Patch& patch, const UvMap& uv_map, Honesty honesty);
/// A plane between two leaves without a common vertex: the vertices of `a`, then those of `b`. The planted
/// mistake: it leaves the last vertex of `b` out.
std::unique_ptr<Certificate> plane_certificate(const Patch& a, const Patch& b, Honesty honesty);

/// Where an attack takes place: the frame of its scene, and how far a collision is forbidden.
struct Ground {
  Frame frame;
  double gap = 0;  ///< Mesh units.
};

struct Tally {
  std::uint64_t attacks = 0, tries = 0, accepted = 0, asked = 0;  ///< asked: exact answers
  double least_ratio = 1e300;  ///< Smallest distance seen over the one promised (see promised_distance).
  void add(const Tally& other);
};

/// Simulated annealing: moves that keep the certificate are taken when they bring the pair closer, or
/// sometimes.
class Attack {
 public:
  Attack(Certificate& certificate, const Ground& ground, std::vector<Vec3> x, Rng& rng);

  /// Tries `tries` moves. What it says is empty, or a collision that the certificate excluded.
  std::string run(int tries, Tally& tally);

 private:
  struct State {
    std::vector<Vec3> x[2];  // mesh units
    std::vector<MovingVertex> vertices;
    double distance = 0;
  };
  void refit(State& state) const;
  void move(State& state);
  void move_vertices(State& state);
  void move_target(State& state);
  void move_all(State& state);
  void snap(State& state);
  double distance(const State& state) const;
  bool in_frame(const State& state) const;
  std::string verdict(const State& state, const FeaturePair& pair, Tally& tally) const;
  std::string look_at_all(const State& state, Tally& tally) const;
  double promised_distance() const;
  FeaturePair choose_target(std::span<const Vec3> x) const;

  Certificate& certificate_;
  Ground ground_;
  Rng& rng_;
  FeaturePair target_;
  double size_;  // of the patch
  State now_;
};

}  // namespace foldproof::search
