/// Statistics over arrays of numbers: PCA, and what training finds by kernel PCA, k-means and CCA.
///
/// Samples are columns. Every function is deterministic: the same input gives the same output, bit by bit, on
/// the same machine. A direction has no natural sign; here its entry of largest magnitude (the first of them)
/// is positive. Functions are pure; any number of threads may call them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "foldproof/base.h"

namespace foldproof {

/// A matrix or vector of the caller, read in place. Columns, blocks and Eigen::Map of plain arrays convert.
using MatrixView = Eigen::Ref<const Eigen::MatrixXd>;
using VectorView = Eigen::Ref<const Eigen::VectorXd>;

/// How many modes a subspace has.
struct SubspaceSize {
  Index modes = 0;        ///< At most this many; 0: as many as `energy` needs.
  double energy = 0.999;  ///< Share of the variance to keep, in (0, 1]. Ignored when `modes` > 0.
};

/// A linear subspace x = mean + basis p (paper, Eq. 1). p has the unit of x.
///
/// `basis` holds float values, so that a file of floats stores it exactly. Its columns are orthonormal to
/// about 1e-7; all functions here allow for that.
struct Pca {
  Eigen::VectorXd mean;
  Eigen::MatrixXd basis;       ///< One column per mode, the mode of largest variance first.
  Eigen::VectorXd deviations;  ///< Standard deviation of the samples along each mode (n - 1), > 0.
  Eigen::VectorXd energy;      ///< Share of the variance in the modes up to and including this one.

  Index modes() const { return static_cast<Index>(basis.cols()); }
  /// Subspace coordinates: the p whose reconstruction is nearest to x (least squares, Eq. 5). Cost: O(modes *
  /// size of x).
  Eigen::VectorXd project(const VectorView& x) const;
  /// mean + basis p.
  Eigen::VectorXd reconstruct(const VectorView& p) const;
  /// The norm of Eq. 8: sqrt(sum (p_k / deviations_k)^2), in standard deviations from the mean.
  double mahalanobis(const VectorView& p) const;
};

/// The principal components of the columns of `samples`. A direction in which they differ only by rounding is
/// not a mode, so one sample, or equal samples, give a subspace without modes.
///
/// Cost: up to 256 samples (or numbers per sample), dense: O(size * samples^2). Above, iterative (Lanczos,
/// Spectra): O(size * samples) per iteration, some iterations per mode. Memory beyond the result: about a
/// megabyte, plus samples^2 numbers when most of the modes are requested. Error: no samples, a number that is
/// not finite, an energy outside (0, 1].
Result<Pca> pca(const MatrixView& samples, const SubspaceSize& size = {});

/// Kernel PCA (Schoelkopf, Smola and Mueller 1998) with the kernel exp(-|x - y|^2 / (2 width^2)), centered.
///
/// It works on the samples' coordinates y in their linear PCA, so its cost does not depend on the size of a
/// sample once x is projected.
struct KernelPca {
  /// The samples' linear PCA: all modes, or, of more than 256 samples, 0.99999 of the energy.
  Pca pca;
  Eigen::MatrixXd samples;     ///< The samples' coordinates in `pca`, a column each.
  double width = 0;            ///< Of the kernel, in the unit of x.
  Eigen::MatrixXd weights;     ///< Samples x modes: p = weights^T (centered kernel values).
  Eigen::VectorXd row_means;   ///< Mean kernel value of each sample with all samples.
  Eigen::VectorXd deviations;  ///< Standard deviation of the samples' p along each mode, > 0.
  Eigen::VectorXd energy;      ///< Share of the variance in feature space up to and including this mode.

  Index modes() const { return static_cast<Index>(weights.cols()); }
  /// p of x. The distance of x from the linear subspace counts, too.
  Eigen::VectorXd project(const VectorView& x) const;
  /// p of the coordinates y = pca.project(x). Cost: O(samples * (modes + pca modes)).
  Eigen::VectorXd project_coordinates(const VectorView& y) const;
  /// A pre-image: a point whose image in feature space is near p. (Most points of feature space are not
  /// images.) It comes from the fixed-point iteration of Mika et al. 1999, started at the sample whose image
  /// is nearest. A step that comes no nearer is halved until it does; if none does, the iteration ends. So
  /// the answer is never worse than the best sample and lies in the linear subspace. With all modes kept, a
  /// sample's p gives that sample.
  Eigen::VectorXd reconstruct(const VectorView& p) const;
  /// The pre-image's coordinates y. Cost: at most 100 iterations of O(samples * pca modes).
  Eigen::VectorXd reconstruct_coordinates(const VectorView& p) const;
  /// sqrt(sum (p_k / deviations_k)^2).
  double mahalanobis(const VectorView& p) const;

 private:
  Eigen::VectorXd project_kernel(Eigen::VectorXd kernel) const;
};

/// A partition of points into clusters.
struct Clusters {
  std::vector<Index> cluster_of;  ///< Per point.
  Eigen::MatrixXd centers;        ///< The mean of each cluster, a column each.
  std::vector<Index> medoids;     ///< Per cluster, the point nearest to its center (the first of them).
  double spread = 0;              ///< Sum of squared distances from the points to their centers.
  /// Mean silhouette (Rousseeuw 1987), in [-1, 1]; 0 for one cluster. How well the clusters are separated.
  double silhouette = 0;

  Index count() const { return static_cast<Index>(centers.cols()); }
};

/// Canonical correlation analysis as a predictor of y from x (paper, Eq. 3).
///
/// The canonical variates of x are weights^T (x - mean_x); y is predicted by ridge regression on the leading
/// ones. With all of them, the prediction F minimizes |F (X - mean_x) - (Y - mean_y)|^2 plus a multiple of
/// |F|^2: Eq. 3 with a ridge.
struct Cca {
  Eigen::VectorXd mean_x, mean_y;
  Eigen::MatrixXd weights;       ///< Size of x, by dimensions.
  Eigen::MatrixXd loadings;      ///< Size of y, by dimensions.
  Eigen::VectorXd correlations;  ///< Regularized canonical correlations, in [0, 1], descending.

  Index dimensions() const { return static_cast<Index>(weights.cols()); }
  /// mean_y + loadings (weights^T (x - mean_x)). Cost: O(dimensions * (size of x + size of y)).
  Eigen::VectorXd predict(const VectorView& x) const;
};

}  // namespace foldproof
