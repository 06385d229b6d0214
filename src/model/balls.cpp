// Balls of a model: which ones, and how a file keeps them.
#include <cmath>

#include "base/try.h"
#include "model/balls_file.h"
#include "reduced/pair_tree.h"

namespace foldproof {
namespace {

// Of the balls and of the proofs behind them (docs/soundness.md, R1 to R8). Raise it with any change after
// which balls of before might not hold: they are then proven anew.
constexpr std::uint32_t kBallsVersion = 1;

/// FNV-1a over the bytes of numbers, little-endian as the file is.
class Hash {
 public:
  template <class T>
  void add(std::span<const T> numbers) {
    add_bytes(std::as_bytes(numbers));
  }
  template <class T>
  void add_one(const T& number) {
    add(std::span(&number, 1));
  }
  std::uint64_t value() const { return value_; }

 private:
  void add_bytes(std::span<const std::byte> bytes) {
    for (const std::byte byte : bytes)
      value_ = (value_ ^ std::to_integer<std::uint64_t>(byte)) * 0x100000001b3u;
  }
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

/// Of the balls and all that they are about: the mesh, its hierarchy, the subspace and the centers.
std::uint64_t hash_of(const Model& model, const ReducedBalls& balls) {
  static_assert(sizeof(ReducedBalls::Pair) == 16);
  const Hierarchy& hierarchy = *model.hierarchy();
  const Pca& subspace = model.learned->pca;
  const auto numbers = [](const auto& matrix) {
    return std::span(matrix.data(), static_cast<std::size_t>(matrix.size()));
  };
  Hash hash;
  hash.add_one(kBallsVersion);
  hash.add_one(topology_hash(hierarchy.topology()));
  hash.add(hierarchy.triangle_ids());
  for (const Hierarchy::Node& node : hierarchy.nodes()) {
    hash.add_one(node.leaf_begin);
    hash.add_one(node.leaf_end);
  }
  for (const Hierarchy::Leaf& leaf : hierarchy.leaves()) hash.add_one(leaf.triangles);
  hash.add_one(subspace.modes());
  hash.add(std::span<const double>(numbers(subspace.mean)));
  for (const double value : numbers(subspace.basis)) hash.add_one(static_cast<float>(value));
  hash.add(std::span<const double>(numbers(subspace.deviations)));
  for (const ReducedCenter& center : ball_centers(*model.learned))
    hash.add(std::span<const double>(center.p));
  hash.add_one(balls.clearance);
  hash.add(std::span<const ReducedBalls::Pair>(balls.pairs));
  hash.add(std::span<const float>(balls.radii));
  return hash.value();
}

Result<std::shared_ptr<const ReducedMotion>> reduced_motion_of(const Model& model) {
  auto motion = FOLDPROOF_TRY(ReducedMotion::make(model.hierarchy(), model.learned->pca));
  return std::make_shared<const ReducedMotion>(std::move(motion));
}

}  // namespace

std::vector<ReducedCenter> ball_centers(const Learned& learned) {
  std::vector<ReducedCenter> centers;
  const auto add = [&](const Eigen::VectorXd& p) {
    double max_radius = std::sqrt(static_cast<double>(p.size())) + 4;
    for (Eigen::Index k = 0; k < learned.coordinates.cols(); ++k)
      max_radius = std::max(max_radius, 1.1 * learned.pca.mahalanobis(learned.coordinates.col(k) - p));
    centers.push_back({{p.data(), p.data() + p.size()}, max_radius});
  };
  add(Eigen::VectorXd::Zero(learned.pca.modes()));
  if (learned.clusters.count() > 1) {
    for (Index c = 0; c < learned.clusters.count(); ++c) add(learned.clusters.centers.col(c));
  }
  return centers;
}

Result<std::shared_ptr<const ReducedShape>> prove_balls(const Model& model, double clearance,
                                                        const ReducedHooks& hooks) {
  auto motion = FOLDPROOF_TRY(reduced_motion_of(model));
  auto shape = FOLDPROOF_TRY(
      ReducedShape::build(std::move(motion), ball_centers(*model.learned), {.clearance = clearance}, hooks));
  return std::make_shared<const ReducedShape>(std::move(shape));
}

Result<std::shared_ptr<const ReducedShape>> kept_balls(const Model& model) {
  auto motion = FOLDPROOF_TRY(reduced_motion_of(model));
  auto shape =
      FOLDPROOF_TRY(ReducedShape::from_balls(std::move(motion), ball_centers(*model.learned), *model.balls));
  return std::make_shared<const ReducedShape>(std::move(shape));
}

flatbuffers::Offset<file::Balls> internal::write_balls(flatbuffers::FlatBufferBuilder& builder,
                                                       const Model& model) {
  const ReducedBalls& balls = *model.balls;
  std::vector<file::BallPair> pairs;
  pairs.reserve(balls.pairs.size());
  for (const ReducedBalls::Pair& pair : balls.pairs)
    pairs.emplace_back(pair.a, pair.b, pair.begin, pair.count);
  const auto pair_vector = builder.CreateVectorOfStructs(pairs);
  const auto radii = builder.CreateVector(balls.radii);
  return file::CreateBalls(builder, kBallsVersion, balls.clearance, pair_vector, radii,
                           hash_of(model, balls));
}

std::uint64_t internal::bound_of_ball_bytes(const ReducedBalls& balls) {
  return 4096 + sizeof(file::BallPair) * balls.pairs.size() + 4 * balls.radii.size();
}

Result<std::shared_ptr<const ReducedBalls>> internal::read_balls(const file::Balls& file, const Model& model,
                                                                 const std::string& path) {
  if (file.version() != kBallsVersion) return nullptr;
  const auto bad = [&](const char* problem) {
    return fail(ErrorCode::InvalidFile, path + ", balls", problem, kCopyAgain);
  };
  if (!model.learned || !file.pairs() || !file.radii()) return bad("have parts missing");
  auto balls = std::make_shared<ReducedBalls>();
  balls->clearance = file.clearance();
  balls->pairs.reserve(file.pairs()->size());
  for (const file::BallPair* pair : *file.pairs())
    balls->pairs.push_back({pair->a(), pair->b(), pair->begin(), pair->count()});
  balls->radii.assign(file.radii()->begin(), file.radii()->end());
  if (hash_of(model, *balls) != file.hash()) return bad("are damaged, or of another model");
  if (!are_balls_of(*model.hierarchy(), ball_centers(*model.learned).size(), *balls))
    return bad("are not of this mesh");
  return balls;
}

}  // namespace foldproof
