// Reads the learned part of a model file, and checks every number of it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/learned_file.h"

namespace foldproof::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Eigen::Index kMaxStoredModes = 1024;
// Bases are rounded to floats, so they are only nearly orthonormal.
constexpr double kNearlyOrthonormal = 1e-4;

template <class T>
Eigen::Index count_of(const flatbuffers::Vector<T>* vector) {
  return vector ? static_cast<Eigen::Index>(vector->size()) : 0;
}

/// Reads part by part; remembers the first bad one.
class LearnedReader {
 public:
  LearnedReader(const file::Learned& file, const Hierarchy& hierarchy, std::size_t poses)
      : file_(file),
        hierarchy_(hierarchy),
        vertices_(hierarchy.topology().vertex_count()),
        model_poses_(poses) {}

  /// Null when some part is bad.
  std::shared_ptr<const Learned> read() {
    auto learned = std::make_shared<Learned>();
    read_settings(*learned);
    read_poses(*learned);
    poses_ = static_cast<Eigen::Index>(learned->poses.size());
    read_subspace(file_.subspace(), "subspace", learned->pca);
    if (file_.kernel()) read_kernel(*file_.kernel(), learned->kernel.emplace());
    require(learned->kernel.has_value() == (learned->settings.subspace == SubspaceKind::KernelPca), "kernel");
    learned->coordinates = matrix(file_.coordinates(), learned->pca.modes(), poses_, "coordinates");
    read_key_points(learned->key_points);
    read_clusters(learned->pca.modes(), learned->clusters);
    if (file_.certificates()) {
      auto map = std::make_shared<CertificateMap>();
      keys_ = 3 * static_cast<Eigen::Index>(learned->key_points.vertices.size());
      read_certificates(*file_.certificates(), *map);
      learned->certificates = std::move(map);
    }
    read_regions(learned->regions);
    return bad_.empty() ? std::move(learned) : nullptr;
  }
  const std::string& bad() const { return bad_; }

 private:
  bool require(bool good, const char* part) {
    if (!good && bad_.empty()) bad_ = part;
    return good;
  }
  static bool is_share(double x) { return x >= 0 && x <= 1; }
  static bool is_distance(double x) { return std::isfinite(x) && x >= 0; }
  bool is_vertex(Index v) const { return v < vertices_ || v == kNoIndex; }

  template <class T>
  MatrixXd matrix(const flatbuffers::Vector<T>* numbers, Eigen::Index rows, Eigen::Index columns,
                  const char* part) {
    const bool fits = rows > 0 ? count_of(numbers) % rows == 0 && count_of(numbers) / rows == columns
                               : count_of(numbers) == 0;
    if (!require(fits && rows > 0 && columns > 0, part)) return {};
    MatrixXd read =
        Eigen::Map<const Eigen::Matrix<T, -1, -1>>(numbers->data(), rows, columns).template cast<double>();
    if (!require(read.allFinite(), part)) return {};
    return read;
  }
  VectorXd vector(const flatbuffers::Vector<double>* numbers, Eigen::Index size, const char* part) {
    const MatrixXd read = matrix(numbers, size, 1, part);
    return read.size() > 0 ? VectorXd(read.col(0)) : VectorXd();
  }
  std::vector<Index> indices(const flatbuffers::Vector<std::uint32_t>* numbers, Index below,
                             const char* part) {
    std::vector<Index> read;
    if (numbers) read.assign(numbers->begin(), numbers->end());
    require(std::all_of(read.begin(), read.end(), [&](Index i) { return i < below; }), part);
    return read;
  }

  void read_settings(Learned& learned) {
    const file::LearnSettings* s = file_.settings();
    if (!require(s != nullptr, "settings")) return;
    require(is_share(s->energy()) && is_share(s->first_share()) && is_share(s->max_share()) &&
                is_distance(s->tolerance()) && s->subspace() <= 1,
            "settings");
    learned.settings = {static_cast<SubspaceKind>(s->subspace()),
                        {s->modes(), s->energy()},
                        {s->first_share(), s->max_share(), s->tolerance(), s->max_rounds()},
                        s->max_clusters(),
                        s->max_poses()};
    learned.size = file_.size();
    require(is_distance(learned.size), "size");
  }

  VertexDistance distance(const file::Distance& d) {
    require(is_distance(d.mean()) && is_distance(d.worst()) && is_vertex(d.worst_vertex()), "poses");
    return {d.mean(), d.worst(), d.worst_vertex()};
  }
  PoseError pose_error(const file::PoseError& e) {
    return {distance(e.projection()), distance(e.cueing()), distance(e.total())};
  }

  void read_poses(Learned& learned) {
    if (!require(count_of(file_.poses()) >= 3, "poses")) return;
    for (const file::LearnedPose* pose : *file_.poses()) {
      const bool ascending = learned.poses.empty() || pose->pose() > learned.poses.back().pose;
      require(ascending && pose->pose() < model_poses_, "poses");
      learned.poses.push_back({pose->pose(), pose_error(pose->trained()), pose_error(pose->leave_one_out())});
    }
  }

  void read_subspace(const file::Subspace* file, const char* part, Pca& out) {
    const Eigen::Index modes = file ? count_of(file->deviations()) : 0;
    if (!require(modes > 0 && modes <= kMaxStoredModes, part)) return;
    out.mean = vector(file->mean(), 3 * Eigen::Index{vertices_}, part);
    out.basis = matrix(file->basis(), 3 * Eigen::Index{vertices_}, modes, part);
    out.deviations = vector(file->deviations(), modes, part);
    out.energy = vector(file->energy(), modes, part);
    if (!bad_.empty()) return;
    require((out.deviations.array() > 0).all() && (out.energy.array() >= 0).all() &&
                (out.energy.array() <= 1 + 1e-9).all(),
            part);
    const MatrixXd products = out.basis.transpose() * out.basis;
    require((products - MatrixXd::Identity(modes, modes)).cwiseAbs().maxCoeff() < kNearlyOrthonormal, part);
  }

  void read_kernel(const file::Kernel& file, KernelPca& out) {
    const char* const part = "kernel";
    read_subspace(file.pca(), part, out.pca);
    const Eigen::Index modes = count_of(file.deviations());
    if (!require(modes <= kMaxStoredModes, part)) return;
    out.samples = matrix(file.samples(), out.pca.modes(), poses_, part);
    out.width = file.width();
    out.weights = matrix(file.weights(), poses_, modes, part);
    out.row_means = vector(file.row_means(), poses_, part);
    out.deviations = vector(file.deviations(), modes, part);
    out.energy = vector(file.energy(), modes, part);
    require(std::isfinite(out.width) && out.width > 0 && (out.deviations.array() > 0).all(), part);
  }

  void read_key_points(KeyPoints& out) {
    const char* const part = "key points";
    out.vertices = indices(file_.key_points(), vertices_, part);
    std::vector<Index> sorted = out.vertices;
    std::sort(sorted.begin(), sorted.end());
    require(!sorted.empty() && std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end(), part);
    if (file_.key_rounds()) out.round_ends.assign(file_.key_rounds()->begin(), file_.key_rounds()->end());
    if (file_.key_errors()) out.errors.assign(file_.key_errors()->begin(), file_.key_errors()->end());
    require(!out.round_ends.empty() && out.round_ends.back() == out.vertices.size() &&
                std::is_sorted(out.round_ends.begin(), out.round_ends.end()) &&
                out.errors.size() == out.round_ends.size() &&
                std::all_of(out.errors.begin(), out.errors.end(), is_distance),
            part);
  }

  void read_clusters(Eigen::Index modes, Clusters& out) {
    const char* const part = "clusters";
    const file::Clusters* file = file_.clusters();
    const auto count = file ? count_of(file->medoids()) : 0;
    if (!require(count > 0 && count <= poses_, part)) return;
    out.centers = matrix(file->centers(), modes, count, part);
    out.cluster_of = indices(file->cluster_of(), static_cast<Index>(count), part);
    out.medoids = indices(file->medoids(), static_cast<Index>(poses_), part);
    out.spread = file->spread();
    out.silhouette = file->silhouette();
    require(static_cast<Eigen::Index>(out.cluster_of.size()) == poses_ && is_distance(out.spread) &&
                out.silhouette >= -1 && out.silhouette <= 1,
            part);
  }

  void read_certificates(const file::Certificates& file, CertificateMap& out) {
    const char* const part = "certificates";
    out.nodes = indices(file.nodes(), static_cast<Index>(hierarchy_.nodes().size()), part);
    const auto out_of_order = std::adjacent_find(out.nodes.begin(), out.nodes.end(), std::greater_equal<>());
    require(out_of_order == out.nodes.end(), part);
    const auto nodes = static_cast<Eigen::Index>(out.nodes.size());
    const Eigen::Index dimensions = count_of(file.correlations());
    if (!require(nodes > 0 && keys_ > 0 && dimensions <= kMaxStoredModes, part)) return;
    out.anchor = vector(file.anchor(), keys_, part);
    out.cca.mean_x = vector(file.mean_x(), keys_, part);
    out.cca.mean_y = vector(file.mean_y(), nodes, part);
    read_cca_matrices(file, nodes, dimensions, out.cca);
    if (file.thresholds()) out.thresholds.assign(file.thresholds()->begin(), file.thresholds()->end());
    for (Eigen::Index k = 0; k < count_of(file.sources()); ++k) {
      const auto source = file.sources()->Get(static_cast<flatbuffers::uoffset_t>(k));
      require(source <= static_cast<std::uint8_t>(CertificateMap::Source::None), part);
      out.sources.push_back(static_cast<CertificateMap::Source>(source));
    }
    require(out.thresholds.size() == out.nodes.size() && out.sources.size() == out.nodes.size() &&
                std::all_of(out.thresholds.begin(), out.thresholds.end(),
                            [](double x) { return std::isfinite(x); }),
            part);
    out.balanced_accuracy = file.balanced_accuracy();
    out.majority_accuracy = file.majority_accuracy();
    out.false_discovery_rate = file.false_discovery_rate();
    require(is_share(out.balanced_accuracy) && is_share(out.majority_accuracy) &&
                is_share(out.false_discovery_rate),
            part);
    read_calibration(file, out);
  }

  void read_calibration(const file::Certificates& file, CertificateMap& out) {
    const char* const part = "certificates";
    if (!require(count_of(file.calibration_excess()) == count_of(file.calibration_miss_rate()), part)) return;
    for (flatbuffers::uoffset_t k = 0; k < count_of(file.calibration_excess()); ++k) {
      const CertificateMap::CalibrationPoint point{file.calibration_excess()->Get(k),
                                                   file.calibration_miss_rate()->Get(k)};
      const bool ordered = out.calibration.empty() || point.excess >= out.calibration.back().excess;
      require(std::isfinite(point.excess) && point.excess >= 0 && is_share(point.miss_rate) && ordered, part);
      out.calibration.push_back(point);
    }
  }

  // Margins that are constant over the poses correlate with nothing: the CCA then has no dimensions.
  void read_cca_matrices(const file::Certificates& file, Eigen::Index nodes, Eigen::Index dimensions,
                         Cca& out) {
    const char* const part = "certificates";
    if (dimensions == 0) {
      require(count_of(file.weights()) == 0 && count_of(file.loadings()) == 0, part);
      out.weights.resize(keys_, 0);
      out.loadings.resize(nodes, 0);
      return;
    }
    out.weights = matrix(file.weights(), keys_, dimensions, part);
    out.loadings = matrix(file.loadings(), nodes, dimensions, part);
    out.correlations = vector(file.correlations(), dimensions, part);
    require((out.correlations.array() >= 0).all() && (out.correlations.array() <= 1 + 1e-9).all(), part);
  }

  void read_regions(std::vector<LearnedRegion>& out) {
    if (!file_.regions()) return;
    for (const file::Region* r : *file_.regions()) {
      require(r->node() < hierarchy_.nodes().size() && (out.empty() || r->node() > out.back().node) &&
                  is_distance(r->mean()) && is_distance(r->worst()) && r->worst_vertex() < vertices_ &&
                  r->worst_pose() < model_poses_,
              "regions");
      out.push_back({r->node(), r->mean(), r->worst(), r->worst_vertex(), r->worst_pose()});
    }
  }

  const file::Learned& file_;
  const Hierarchy& hierarchy_;
  const Index vertices_;
  const std::size_t model_poses_;
  Eigen::Index poses_ = 0, keys_ = 0;
  std::string bad_;
};

}  // namespace

Result<std::shared_ptr<const Learned>> read_learned(const file::Learned& file, const Hierarchy& hierarchy,
                                                    std::size_t poses, const std::string& path) {
  LearnedReader reader(file, hierarchy, poses);
  if (auto learned = reader.read()) return learned;
  return fail(ErrorCode::InvalidFile, fmt::format("{}, learned {}", path, reader.bad()), "is damaged",
              kCopyAgain);
}

}  // namespace foldproof::internal
