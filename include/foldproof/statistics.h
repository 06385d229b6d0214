/// Statistics over arrays: PCA, kernel PCA, k-means, CCA and LDA. What a number means is the caller's
/// business.
///
/// Samples are columns. Every function here is deterministic: the same input gives the same output, bit by
/// bit, on the same machine. Directions have no natural sign; theirs is chosen so that the entry of largest
/// magnitude (the first of them) is positive. Functions are pure and may be called from any number of
/// threads.
#pragma once

#include <vector>

#include "foldproof/base.h"

namespace foldproof {

/// A matrix or vector of the caller, read in place. Columns, blocks and Eigen::Map of plain arrays fit too.
using MatrixView = Eigen::Ref<const Eigen::MatrixXd>;
using VectorView = Eigen::Ref<const Eigen::VectorXd>;

/// How many modes a subspace has.
struct SubspaceSize {
  Index modes = 0;        ///< At most so many; 0: as many as the energy asks for.
  double energy = 0.999;  ///< Share of the variance to keep, in (0, 1]. Not used when `modes` says how many.
};

/// A linear subspace x = mean + basis p (paper, Eq. 1). p has the unit of x.
///
/// `basis` is rounded to float values so that a file of floats holds it exactly; its columns are orthonormal
/// to about 1e-7, and everything else here takes it as it is.
struct Pca {
  Eigen::VectorXd mean;
  Eigen::MatrixXd basis;       ///< One column per mode, the mode of largest variance first.
  Eigen::VectorXd deviations;  ///< Standard deviation of the samples along each mode (n - 1), > 0.
  Eigen::VectorXd energy;      ///< Share of the variance in the modes up to and with this one.

  Index modes() const { return static_cast<Index>(basis.cols()); }
  /// The p that rebuilds x best in the sense of least squares (Eq. 5). Cost: O(modes * size of x).
  Eigen::VectorXd project(const VectorView& x) const;
  /// mean + basis p.
  Eigen::VectorXd rebuild(const VectorView& p) const;
  /// The norm of Eq. 8: sqrt(sum (p_k / deviations_k)^2), standard deviations from the mean.
  double mahalanobis(const VectorView& p) const;
};

/// The principal components of the columns of `samples`. A direction in which they differ by no more than
/// rounding is no mode, so one sample, or equal samples, give a subspace without modes.
///
/// Cost: at most 256 samples (or numbers per sample): dense, O(size * samples^2). More: iterative (Lanczos,
/// Spectra), O(size * samples) per iteration and some iterations per mode. Memory beyond the result: about a
/// megabyte, and samples^2 numbers when most of the modes are asked for. Error: no samples, a number that is
/// not finite, an energy outside (0, 1].
Result<Pca> pca(const MatrixView& samples, const SubspaceSize& size = {});

/// Kernel PCA (Schoelkopf, Smola and Mueller 1998) with the kernel exp(-|x - y|^2 / (2 width^2)), centred.
///
/// It works on the samples' coordinates in their own linear span, so its run time does not depend on the size
/// of a sample once x is in coordinates of the span.
struct KernelPca {
  Pca span;  ///< Of the samples: every direction with any spread; of more than 256 samples, 0.99999 of the
             ///< energy.
  Eigen::MatrixXd samples;     ///< The samples in coordinates of the span, a column each.
  double width = 0;            ///< Of the kernel, in the unit of x.
  Eigen::MatrixXd weights;     ///< Samples x modes: p = weights^T (centred kernel values).
  Eigen::VectorXd row_means;   ///< Mean kernel value of each sample with all samples.
  Eigen::VectorXd deviations;  ///< Standard deviation of the samples' p along each mode, > 0.
  Eigen::VectorXd energy;      ///< Share of the variance in feature space up to and with this mode.

  Index modes() const { return static_cast<Index>(weights.cols()); }
  /// What lies outside the span counts as distance, as the kernel has it.
  Eigen::VectorXd project(const VectorView& x) const;
  /// The same for `y`, coordinates in the span (span.project(x)). Cost: O(samples * (modes + span modes)).
  Eigen::VectorXd project_span(const VectorView& y) const;
  /// A point whose image in feature space is near p, as few points of feature space are images: the
  /// fixed-point iteration of Mika et al. 1999 for the nearest image, from the sample whose image is nearest.
  /// A step that does not come nearer is halved until it does; when none does, the iteration ends. So the
  /// answer is never worse than the best sample, it lies in the samples' span, and one sample's p gives that
  /// sample when all modes are kept.
  Eigen::VectorXd rebuild(const VectorView& p) const;
  /// The same in coordinates of the span. Cost: at most 100 iterations of O(samples * span modes).
  Eigen::VectorXd rebuild_span(const VectorView& p) const;
  /// sqrt(sum (p_k / deviations_k)^2).
  double mahalanobis(const VectorView& p) const;

 private:
  Eigen::VectorXd project_kernel(Eigen::VectorXd kernel) const;
};

/// `width` 0: four times the median distance between two samples that differ. With narrower kernels what is
/// rebuilt clings to the samples: held-out frames of a hand (40 samples, energy 0.999) came back with a mean
/// error of 0.045 at one median distance, 0.033 at two, 0.026 at four and at eight, and 0.028 from linear
/// PCA. Errors and cost as pca with all modes, and an error when the width is negative or not finite.
Result<KernelPca> kernel_pca(const MatrixView& samples, const SubspaceSize& size = {}, double width = 0);

/// Points in groups.
struct Clusters {
  std::vector<Index> cluster_of;  ///< Per point.
  Eigen::MatrixXd centres;        ///< The mean of each group, a column each.
  std::vector<Index> medoids;     ///< Per group, the point nearest to its centre (the first of them).
  double spread = 0;              ///< Sum of squared distances from the points to their centres.
  /// Mean silhouette (Rousseeuw 1987), in [-1, 1]; 0 for one group. How clearly the groups stand apart.
  double silhouette = 0;

  Index count() const { return static_cast<Index>(centres.cols()); }
};

/// At most `count` groups of the columns of `points`, none of them empty: fewer only when there are fewer
/// different points. Lloyd's iteration from the starts of k-means++ (Arthur and Vassilvitskii 2007) with
/// fixed seeds; the tightest of 10 tries. Groups are numbered by their first point. Error: no points, a
/// number that is not finite, count 0. Cost: O(points * count * size) per iteration, and O(points^2 * size)
/// for the silhouette.
Result<Clusters> k_means(const MatrixView& points, Index count);

/// The same with the count that shows best: the number of groups from 2 to `most` of largest mean silhouette,
/// or one group when that is below 0.25 (no substantial structure by the usual reading, Kaufman and Rousseeuw
/// 1990).
Result<Clusters> cluster(const MatrixView& points, Index most);

/// Canonical correlation analysis as a predictor of y from x (paper, Eq. 3).
///
/// The canonical variates of x are weights^T (x - mean_x); y is predicted by ridge regression on the leading
/// ones. With all of them it is the minimum of |F (X - mean_x) - (Y - mean_y)|^2 plus a multiple of |F|^2,
/// Eq. 3 with a ridge.
struct Cca {
  Eigen::VectorXd mean_x, mean_y;
  Eigen::MatrixXd weights;       ///< Size of x, by dimensions.
  Eigen::MatrixXd loads;         ///< Size of y, by dimensions.
  Eigen::VectorXd correlations;  ///< Regularised canonical correlations, in [0, 1], descending.

  Index dimensions() const { return static_cast<Index>(weights.cols()); }
  /// mean_y + loads (weights^T (x - mean_x)). Cost: O(dimensions * (size of x + size of y)).
  Eigen::VectorXd predict(const VectorView& x) const;
};

/// From samples that stand in the same columns of both. Fewer dimensions come out when the samples span
/// fewer. `ridge`: what is added to the diagonal of both covariances, as a share of their mean variance over
/// the directions that have any; > 0, for with fewer samples than numbers everything correlates perfectly
/// without it. Error: no samples or not the same number, a number that is not finite, dimensions 0, ridge not
/// > 0. Cost: O(size * samples^2 + samples^3); nothing of size^2.
Result<Cca> cca(const MatrixView& x_samples, const MatrixView& y_samples, Index dimensions,
                double ridge = 1e-3);

/// Fisher's linear discriminant of two classes: the direction that tells them apart, and where to cut.
struct Lda {
  Eigen::VectorXd direction;  ///< Unit length, from class 0 to class 1.
  double threshold = 0;
  double error = 0;  ///< Share of the given points that fall on the wrong side: mean of both classes' shares.

  /// Above 0: class 1.
  double score(const VectorView& x) const { return direction.dot(x) - threshold; }
};

/// `is_class_1`: one entry per column of `points`, 0 or not 0. The direction is S^-1 (mean_1 - mean_0) with S
/// the covariance within the classes, plus `ridge` times its mean variance (over the directions the points
/// span) on the diagonal. The threshold is the cut of least `error` among those midway between neighbouring
/// scores; of equals, the one in the widest gap. Error: sizes differ, a number that is not finite, a class
/// without points, classes that no cut along the direction can tell apart (equal means), ridge not > 0. Cost:
/// O(size * points^2 + points^3), or with size when it is smaller.
Result<Lda> lda(const MatrixView& points, std::span<const std::uint8_t> is_class_1, double ridge = 1e-3);

}  // namespace foldproof
