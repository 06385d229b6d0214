#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "statistics/span.h"

namespace foldproof {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kTries = 10;
constexpr int kMostIterations = 200;
constexpr double kSubstantial = 0.25;

struct Nearest {
  Index cluster;
  double squared;
};

Nearest nearest_centre(const MatrixXd& centres, const VectorView& point) {
  Nearest best{0, std::numeric_limits<double>::infinity()};
  for (Eigen::Index c = 0; c < centres.cols(); ++c) {
    const double squared = (centres.col(c) - point).squaredNorm();
    if (squared < best.squared) best = {static_cast<Index>(c), squared};
  }
  return best;
}

// k-means++: each next centre is a point, drawn with a probability in proportion to its squared distance from
// the centres so far. Fewer centres than asked for when every point is a centre.
MatrixXd first_centres(const MatrixView& points, Index count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  // Not std::uniform_real_distribution, whose numbers differ between standard libraries.
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };

  MatrixXd centres(points.rows(), count);
  const auto n = points.cols();
  centres.col(0) = points.col(static_cast<Eigen::Index>(uniform() * static_cast<double>(n)));
  VectorXd squared = (points.colwise() - centres.col(0)).colwise().squaredNorm();
  Eigen::Index made = 1;
  while (made < count && squared.maxCoeff() > 0) {
    double left = uniform() * squared.sum();
    Eigen::Index chosen = 0;
    for (Eigen::Index k = 0; k < n; ++k) {
      if (squared[k] == 0) continue;
      chosen = k;
      left -= squared[k];
      if (left < 0) break;
    }
    centres.col(made) = points.col(chosen);
    const VectorXd to_new = (points.colwise() - centres.col(made)).colwise().squaredNorm();
    squared = squared.cwiseMin(to_new);
    ++made;
  }
  return centres.leftCols(made);
}

// Gives every empty group the point that is farthest from its own centre. There are at least as many
// different points as groups, so while a group is empty another one holds two different points.
void fill_empty(const MatrixView& points, Clusters& clusters) {
  std::vector<Index> sizes(clusters.count(), 0);
  for (const Index c : clusters.cluster_of) ++sizes[c];
  for (Index empty = 0; empty < clusters.count(); ++empty) {
    if (sizes[empty] > 0) continue;
    Index farthest = 0;
    double most = -1;
    for (Index k = 0; k < clusters.cluster_of.size(); ++k) {
      const Index c = clusters.cluster_of[k];
      const double squared = (points.col(k) - clusters.centres.col(c)).squaredNorm();
      if (sizes[c] > 1 && squared > most) farthest = k, most = squared;
    }
    --sizes[clusters.cluster_of[farthest]];
    clusters.cluster_of[farthest] = empty;
    clusters.centres.col(empty) = points.col(farthest);
    sizes[empty] = 1;
  }
}

void move_centres(const MatrixView& points, Clusters& clusters) {
  std::vector<double> sizes(clusters.count(), 0);
  clusters.centres.setZero();
  for (Index k = 0; k < clusters.cluster_of.size(); ++k) {
    clusters.centres.col(clusters.cluster_of[k]) += points.col(k);
    ++sizes[clusters.cluster_of[k]];
  }
  for (Index c = 0; c < clusters.count(); ++c) clusters.centres.col(c) /= sizes[c];
}

Clusters lloyd(const MatrixView& points, MatrixXd centres) {
  Clusters clusters;
  clusters.centres = std::move(centres);
  clusters.cluster_of.assign(points.cols(), 0);
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const std::vector<Index> before = clusters.cluster_of;
    for (Index k = 0; k < before.size(); ++k) {
      clusters.cluster_of[k] = nearest_centre(clusters.centres, points.col(k)).cluster;
    }
    fill_empty(points, clusters);
    if (iteration > 0 && clusters.cluster_of == before) break;
    move_centres(points, clusters);
  }
  for (Index k = 0; k < clusters.cluster_of.size(); ++k) {
    clusters.spread += (points.col(k) - clusters.centres.col(clusters.cluster_of[k])).squaredNorm();
  }
  return clusters;
}

void number_by_first_point(Clusters& clusters) {
  std::vector<Index> new_number(clusters.count(), kNoIndex);
  MatrixXd centres(clusters.centres.rows(), clusters.centres.cols());
  Index next = 0;
  for (Index& c : clusters.cluster_of) {
    if (new_number[c] == kNoIndex) {
      centres.col(next) = clusters.centres.col(c);
      new_number[c] = next++;
    }
    c = new_number[c];
  }
  clusters.centres = std::move(centres);
}

void find_medoids(const MatrixView& points, Clusters& clusters) {
  clusters.medoids.assign(clusters.count(), kNoIndex);
  std::vector<double> least(clusters.count(), std::numeric_limits<double>::infinity());
  for (Index k = 0; k < clusters.cluster_of.size(); ++k) {
    const Index c = clusters.cluster_of[k];
    const double squared = (points.col(k) - clusters.centres.col(c)).squaredNorm();
    if (squared < least[c]) least[c] = squared, clusters.medoids[c] = k;
  }
}

// A point alone in its group counts 0, as Rousseeuw has it.
double mean_silhouette(const MatrixView& points, const Clusters& clusters) {
  if (clusters.count() < 2) return 0;
  std::vector<double> sizes(clusters.count(), 0);
  for (const Index c : clusters.cluster_of) ++sizes[c];
  double sum = 0;
  for (Index k = 0; k < clusters.cluster_of.size(); ++k) {
    const Index own = clusters.cluster_of[k];
    if (sizes[own] < 2) continue;
    VectorXd to_group = VectorXd::Zero(clusters.count());
    for (Index other = 0; other < clusters.cluster_of.size(); ++other) {
      to_group[clusters.cluster_of[other]] += (points.col(k) - points.col(other)).norm();
    }
    const double inside = to_group[own] / (sizes[own] - 1);
    double outside = std::numeric_limits<double>::infinity();
    for (Index c = 0; c < clusters.count(); ++c) {
      if (c != own) outside = std::min(outside, to_group[c] / sizes[c]);
    }
    const double larger = std::max(inside, outside);
    if (larger > 0) sum += (outside - inside) / larger;
  }
  return sum / static_cast<double>(clusters.cluster_of.size());
}

}  // namespace

Result<Clusters> k_means(const MatrixView& points, Index count) {
  if (auto checked = check_columns(points, "point"); !checked) return tl::unexpected(checked.error());
  if (count == 0) return fail("clusters", "none are asked for", "ask for at least one");
  count = std::min(count, static_cast<Index>(points.cols()));
  Clusters best;
  for (int seed = 1; seed <= kTries; ++seed) {
    Clusters clusters = lloyd(points, first_centres(points, count, seed));
    if (seed == 1 || clusters.spread < best.spread) best = std::move(clusters);
  }
  number_by_first_point(best);
  find_medoids(points, best);
  best.silhouette = mean_silhouette(points, best);
  return best;
}

Result<Clusters> cluster(const MatrixView& points, Index most) {
  auto best = k_means(points, most == 0 ? 0 : 1);
  for (Index count = 2; best && count <= std::min(most, static_cast<Index>(points.cols())); ++count) {
    auto clusters = k_means(points, count);
    if (clusters && clusters->silhouette >= kSubstantial && clusters->silhouette > best->silhouette) {
      best = std::move(clusters);
    }
  }
  return best;
}

}  // namespace foldproof
