#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/try.h"
#include "statistics/thin_svd.h"
#include "statistics/training.h"

namespace foldproof::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRuns = 10;
constexpr int kMaxRounds = 200;
constexpr double kMinSilhouette = 0.25;

struct NearestCenter {
  Index cluster;
  double squared;
};

NearestCenter nearest_center(const MatrixXd& centers, const VectorView& point) {
  NearestCenter best{0, std::numeric_limits<double>::infinity()};
  for (Eigen::Index c = 0; c < centers.cols(); ++c) {
    const double squared = (centers.col(c) - point).squaredNorm();
    if (squared < best.squared) best = {static_cast<Index>(c), squared};
  }
  return best;
}

// k-means++: each next center is a point, chosen at random with a probability in proportion to its squared
// distance from the centers so far. Returns fewer than `count` centers when every point is one.
MatrixXd initial_centers(const MatrixView& points, Index count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  // Not std::uniform_real_distribution, whose numbers differ between standard libraries.
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };

  MatrixXd centers(points.rows(), count);
  const auto n = points.cols();
  centers.col(0) = points.col(static_cast<Eigen::Index>(uniform() * static_cast<double>(n)));
  VectorXd squared = (points.colwise() - centers.col(0)).colwise().squaredNorm();
  Eigen::Index found = 1;
  while (found < count && squared.maxCoeff() > 0) {
    double remaining = uniform() * squared.sum();
    Eigen::Index chosen = 0;
    for (Eigen::Index k = 0; k < n; ++k) {
      if (squared[k] == 0) continue;
      chosen = k;
      remaining -= squared[k];
      if (remaining < 0) break;
    }
    centers.col(found) = points.col(chosen);
    const VectorXd to_new = (points.colwise() - centers.col(found)).colwise().squaredNorm();
    squared = squared.cwiseMin(to_new);
    ++found;
  }
  return centers.leftCols(found);
}

// Moves to every empty cluster the point that is farthest from its own center. There are at least as many
// different points as clusters, so while one cluster is empty another one holds two different points.
void fill_empty_clusters(const MatrixView& points, Clusters& clusters) {
  std::vector<Index> sizes(clusters.count(), 0);
  for (const Index c : clusters.cluster_of) ++sizes[c];
  for (Index empty = 0; empty < clusters.count(); ++empty) {
    if (sizes[empty] > 0) continue;
    Index farthest = 0;
    double largest = -1;
    for (Index k = 0; k < clusters.cluster_of.size(); ++k) {
      const Index c = clusters.cluster_of[k];
      const double squared = (points.col(k) - clusters.centers.col(c)).squaredNorm();
      if (sizes[c] > 1 && squared > largest) farthest = k, largest = squared;
    }
    --sizes[clusters.cluster_of[farthest]];
    clusters.cluster_of[farthest] = empty;
    clusters.centers.col(empty) = points.col(farthest);
    sizes[empty] = 1;
  }
}

void update_centers(const MatrixView& points, Clusters& clusters) {
  std::vector<double> sizes(clusters.count(), 0);
  clusters.centers.setZero();
  for (Index k = 0; k < clusters.cluster_of.size(); ++k) {
    clusters.centers.col(clusters.cluster_of[k]) += points.col(k);
    ++sizes[clusters.cluster_of[k]];
  }
  for (Index c = 0; c < clusters.count(); ++c) clusters.centers.col(c) /= sizes[c];
}

Clusters lloyd(const MatrixView& points, MatrixXd centers) {
  Clusters clusters;
  clusters.centers = std::move(centers);
  clusters.cluster_of.assign(points.cols(), 0);
  for (int iteration = 0; iteration < kMaxRounds; ++iteration) {
    const std::vector<Index> before = clusters.cluster_of;
    for (Index k = 0; k < before.size(); ++k) {
      clusters.cluster_of[k] = nearest_center(clusters.centers, points.col(k)).cluster;
    }
    fill_empty_clusters(points, clusters);
    if (iteration > 0 && clusters.cluster_of == before) break;
    update_centers(points, clusters);
  }
  for (Index k = 0; k < clusters.cluster_of.size(); ++k) {
    clusters.spread += (points.col(k) - clusters.centers.col(clusters.cluster_of[k])).squaredNorm();
  }
  return clusters;
}

void number_by_first_point(Clusters& clusters) {
  std::vector<Index> new_number(clusters.count(), kNoIndex);
  MatrixXd centers(clusters.centers.rows(), clusters.centers.cols());
  Index next = 0;
  for (Index& c : clusters.cluster_of) {
    if (new_number[c] == kNoIndex) {
      centers.col(next) = clusters.centers.col(c);
      new_number[c] = next++;
    }
    c = new_number[c];
  }
  clusters.centers = std::move(centers);
}

void find_medoids(const MatrixView& points, Clusters& clusters) {
  clusters.medoids.assign(clusters.count(), kNoIndex);
  std::vector<double> least(clusters.count(), std::numeric_limits<double>::infinity());
  for (Index k = 0; k < clusters.cluster_of.size(); ++k) {
    const Index c = clusters.cluster_of[k];
    const double squared = (points.col(k) - clusters.centers.col(c)).squaredNorm();
    if (squared < least[c]) least[c] = squared, clusters.medoids[c] = k;
  }
}

// A point alone in its cluster has silhouette 0 (Rousseeuw).
double mean_silhouette(const MatrixView& points, const Clusters& clusters) {
  if (clusters.count() < 2) return 0;
  std::vector<double> sizes(clusters.count(), 0);
  for (const Index c : clusters.cluster_of) ++sizes[c];
  double sum = 0;
  for (Index k = 0; k < clusters.cluster_of.size(); ++k) {
    const Index own = clusters.cluster_of[k];
    if (sizes[own] < 2) continue;
    VectorXd to_cluster = VectorXd::Zero(clusters.count());
    for (Index other = 0; other < clusters.cluster_of.size(); ++other) {
      to_cluster[clusters.cluster_of[other]] += (points.col(k) - points.col(other)).norm();
    }
    const double inside = to_cluster[own] / (sizes[own] - 1);
    double outside = std::numeric_limits<double>::infinity();
    for (Index c = 0; c < clusters.count(); ++c) {
      if (c != own) outside = std::min(outside, to_cluster[c] / sizes[c]);
    }
    const double larger = std::max(inside, outside);
    if (larger > 0) sum += (outside - inside) / larger;
  }
  return sum / static_cast<double>(clusters.cluster_of.size());
}

}  // namespace

Result<Clusters> k_means(const MatrixView& points, Index count) {
  FOLDPROOF_TRY(check_columns(points, "point"));
  if (count == 0) return fail(ErrorCode::InvalidArgument, "clusters", "are 0", "give at least one");
  count = std::min(count, static_cast<Index>(points.cols()));
  Clusters best;
  for (int seed = 1; seed <= kRuns; ++seed) {
    Clusters clusters = lloyd(points, initial_centers(points, count, seed));
    if (seed == 1 || clusters.spread < best.spread) best = std::move(clusters);
  }
  number_by_first_point(best);
  find_medoids(points, best);
  best.silhouette = mean_silhouette(points, best);
  return best;
}

Result<Clusters> cluster(const MatrixView& points, Index max_count) {
  auto best = k_means(points, max_count == 0 ? 0 : 1);
  for (Index count = 2; best && count <= std::min(max_count, static_cast<Index>(points.cols())); ++count) {
    auto clusters = k_means(points, count);
    if (clusters && clusters->silhouette >= kMinSilhouette && clusters->silhouette > best->silhouette) {
      best = std::move(clusters);
    }
  }
  return best;
}

}  // namespace foldproof::internal
