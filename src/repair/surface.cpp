#include "repair/surface.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/parallel.h"

namespace foldproof {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLeastCotangent = 0.02, kLargestCotangent = 5;
constexpr double kLeastArea = 0.2, kLargestArea = 5;     // relative to the mean
constexpr std::size_t kGrain = 256, kCheapGrain = 4096;  // vertices that a thread takes at once
constexpr int kMaxIterations = 120;                      // where pairs on ways are stiff, more gain little

// Edge weights: half of the sum of the cotangents of opposite angles; 1 for lines.
std::vector<double> cotangent_weights(const RepairScene& scene, std::span<const double> rest) {
  const auto edges = scene.edges();
  std::vector<double> weights(edges.size(), 0);
  const auto row_of = [&](Index a, Index b) {
    const Edge e{std::min(a, b), std::max(a, b)};
    return std::lower_bound(edges.begin(), edges.end(), e) - edges.begin();
  };
  for (const Triangle& t : scene.triangles()) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    const std::array<Vec3, 3> p{at(rest, t[0]), at(rest, t[1]), at(rest, t[2])};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 u = p[(k + 1) % 3] - p[k], v = p[(k + 2) % 3] - p[k];
      const double sine = u.cross(v).norm();
      const double cotangent =
          sine > 0 ? std::clamp(u.dot(v) / sine, kLeastCotangent, kLargestCotangent) : kLargestCotangent;
      weights[row_of(t[(k + 1) % 3], t[(k + 2) % 3])] += cotangent / 2;
    }
  }
  for (double& w : weights) {
    if (w == 0) w = 1;
  }
  return weights;
}

// A third of the area of its triangles per vertex, relative to the mean of those that may move.
std::vector<double> relative_areas(const RepairScene& scene, std::span<const double> rest, double& mean) {
  std::vector<double> area(scene.vertex_count(), 0);
  for (const Triangle& t : scene.triangles()) {
    const Vec3 a = at(rest, t[0]);
    const double third = (at(rest, t[1]) - a).cross(at(rest, t[2]) - a).norm() / 6;
    for (const Index v : t) area[v] += third;
  }
  double sum = 0;
  std::size_t count = 0;
  for (Index v = 0; v < area.size(); ++v) {
    if (scene.is_movable(v) && area[v] > 0) sum += area[v], ++count;
  }
  mean = count > 0 ? sum / static_cast<double>(count) : 0;
  for (double& a : area) a = mean > 0 ? std::clamp(a / mean, kLeastArea, kLargestArea) : 1.0;
  return area;
}

// The rotation R that maximizes trace(R M), from a first guess: Newton's method on rotations, else an SVD.
Matrix3d fit_rotation(const Matrix3d& m, Matrix3d r) {
  constexpr int kMaxSteps = 8;
  constexpr double kDone = 1e-6;  // of the square of an angle: the next one would be that small
  for (int step = 0; step < kMaxSteps; ++step) {
    const Matrix3d s = r * m;
    const Vector3d gradient(s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0));
    const Matrix3d hessian = s.trace() * Matrix3d::Identity() - 0.5 * (s + s.transpose());
    const bool is_definite =
        hessian(0, 0) > 0 && hessian.topLeftCorner<2, 2>().determinant() > 0 && hessian.determinant() > 0;
    if (!is_definite) break;
    const Vector3d turn = hessian.inverse() * gradient;
    const double square = turn.squaredNorm();
    if (!(square < 1)) break;
    const Eigen::Quaterniond q(1, turn[0] / 2, turn[1] / 2, turn[2] / 2);
    r = q.normalized().toRotationMatrix() * r;
    if (square < kDone) return r;
  }
  const Eigen::JacobiSVD<Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d u = svd.matrixU();
  if ((svd.matrixV() * u.transpose()).determinant() < 0) u.col(2) *= -1;
  return svd.matrixV() * u.transpose();
}

Vec3 times(const Matrix3d& m, const Vec3& v) { return to_vec3(m * to_eigen(v)); }

}  // namespace

SceneSize internal::scene_size(const RepairScene& scene, std::span<const double> x) {
  std::vector<double> lengths;
  for (const Edge& e : scene.edges()) {
    if (scene.is_movable(e[0]) || scene.is_movable(e[1]))
      lengths.push_back((at(x, e[0]) - at(x, e[1])).norm());
  }
  SceneSize out;
  Vec3 middle;
  double count = 0;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.is_movable(v)) middle += at(x, v), ++count;
  }
  middle /= count;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.is_movable(v)) out.size = std::max(out.size, 2 * (at(x, v) - middle).norm());
  }
  if (!lengths.empty()) {
    const auto half = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), half, lengths.end());
    out.edge = *half;
  }
  if (out.edge == 0) out.edge = out.size / 100;  // points, or all edges are points
  return out;
}

ElasticSurface::ElasticSurface(const RepairScene& scene, std::span<const double> rest, double falloff) {
  double mean = 0;
  diagonal_ = relative_areas(scene, rest, mean);
  const auto weights = cotangent_weights(scene, rest);
  const double scale = mean > 0 ? falloff * falloff / mean : 1;
  const std::size_t n = diagonal_.size();
  begin_.assign(n + 1, 0);
  for (const Edge& e : scene.edges()) {
    for (const Index v : e) ++begin_[v + std::size_t{1}];
  }
  for (std::size_t v = 0; v < n; ++v) begin_[v + 1] += begin_[v];
  neighbors_.resize(begin_.back());
  auto next = begin_;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const auto [a, b] = scene.edges()[k];
    const double weight = scale * weights[k];
    neighbors_[next[a]++] = {b, weight};
    neighbors_[next[b]++] = {a, weight};
    diagonal_[a] += weight;
    diagonal_[b] += weight;
  }
  is_active_.assign(n, 0);
  rotations_.assign(n, Matrix3d::Zero());
  inverse_.resize(n);
  for (auto* vectors : {&turned_, &rhs_, &d_, &r_, &z_, &p_, &q_}) vectors->assign(n, Vec3());
}

void ElasticSurface::set_active(std::vector<Index> active) {
  for (const Index v : active_) is_active_[v] = 0;
  for (const Index v : active) is_active_[v] = 1;
  for (const Index v : active_) {
    if (is_active_[v] == 0) rotations_[v].setZero(), d_[v] = p_[v] = Vec3();
  }
  active_ = std::move(active);
}

void ElasticSurface::fit_rotations(std::span<const double> x, std::span<const double> target) {
  parallel_for(IndexRange{0, active_.size()}, kGrain, [&](IndexRange block) {
    for (const Index v : std::span(active_).subspan(block.begin, block.size())) {
      Matrix3d m = Matrix3d::Zero();
      double size = 0;
      for (const auto& [u, weight] : neighbors(v)) {
        const Vector3d t = to_eigen(at(target, v) - at(target, u));
        m += weight * t * to_eigen(at(x, v) - at(x, u)).transpose();
        size += weight * t.squaredNorm();
      }
      m.diagonal().array() += 1e-9 * size;
      rotations_[v] = size > 0 ? fit_rotation(m, rotations_[v] + Matrix3d::Identity()) : Matrix3d::Identity();
      rotations_[v] -= Matrix3d::Identity();
    }
  });
  parallel_for(IndexRange{0, active_.size()}, kGrain, [&](IndexRange block) {
    for (const Index v : std::span(active_).subspan(block.begin, block.size())) {
      turned_[v] = Vec3();
      for (const auto& [u, weight] : neighbors(v))
        turned_[v] += 0.5 * weight * times(rotations_[v] + rotations_[u], at(target, v) - at(target, u));
    }
  });
}

void ElasticSurface::carry(std::span<const double> from, std::span<const double> to, std::span<double> x) {
  std::vector<Index> moved;
  for (Index v = 0; v < is_active_.size(); ++v) {
    if (at(x, v) != at(from, v))
      moved.push_back(v);
    else
      put(x, v, at(to, v));
  }
  set_active({});
  set_active(std::move(moved));
  fit_rotations(to, from);
  for (const Index v : active_) {
    const Vec3 d = at(x, v) - at(from, v);
    put(x, v, at(to, v) + d + times(rotations_[v], d));
  }
  set_active({});
}

// Of the system without contacts, times values of vertices.
template <class Value>
Vec3 ElasticSurface::row(Index v, const Value& value) const {
  Vec3 sum = diagonal_[v] * value(v);
  for (const auto& [u, weight] : neighbors(v)) sum -= weight * value(u);
  return sum;
}

double ElasticSurface::energy(std::span<const double> x, std::span<const double> target,
                              std::span<const NearPair> pairs, double stiffness) const {
  double sum = 0;
  const auto correction = [&](Index v) { return at(x, v) - at(target, v); };
  for (const Index v : active_) sum += correction(v).dot(0.5 * row(v, correction) - turned_[v]);
  for (const NearPair& pair : pairs) sum += stiffness * barrier(pair.gap, pair.range);
  return sum;
}

void ElasticSurface::build_contacts(std::span<const double> x, std::span<const double> target,
                                    std::span<const NearPair> pairs, double stiffness) {
  for (const Index v : active_) {
    rhs_[v] = turned_[v];
    inverse_[v] = diagonal_[v] * Matrix3d::Identity();
  }
  contacts_.clear();
  for (const NearPair& pair : pairs) {
    Contact c{stiffness * barrier_curvature(pair.gap, pair.range), pair.normal, pair.vertices, pair.w};
    double change = 0;  // of the gap, if all vertices went to their targets
    for (std::size_t k = 0; k < 4; ++k) {
      const Index v = pair.vertices[k];
      change += pair.w[k] * pair.normal.dot(at(target, v) - at(x, v));
      if (is_active_[v] == 0) c.w[k] = 0;
    }
    const double force = -(stiffness * barrier_slope(pair.gap, pair.range) + c.curvature * change);
    const Matrix3d block = c.curvature * to_eigen(c.normal) * to_eigen(c.normal).transpose();
    for (std::size_t k = 0; k < 4; ++k) {
      rhs_[c.vertices[k]] += force * c.w[k] * c.normal;
      inverse_[c.vertices[k]] += c.w[k] * c.w[k] * block;
    }
    contacts_.push_back(c);
  }
  for (const Index v : active_) inverse_[v] = Matrix3d(inverse_[v].inverse());
}

void ElasticSurface::multiply(std::span<const Vec3> u, std::span<Vec3> out) const {
  parallel_for(IndexRange{0, active_.size()}, kCheapGrain, [&](IndexRange block) {
    for (const Index v : std::span(active_).subspan(block.begin, block.size()))
      out[v] = row(v, [&](Index i) { return u[i]; });
  });
  for (const Contact& c : contacts_) {
    Vec3 sum;
    for (std::size_t k = 0; k < 4; ++k) sum += c.w[k] * u[c.vertices[k]];
    const Vec3 along = c.curvature * c.normal.dot(sum) * c.normal;
    for (std::size_t k = 0; k < 4; ++k) out[c.vertices[k]] += c.w[k] * along;
  }
}

// Goes `step` along p_, then makes p_ the next direction. Returns r z; `largest`: the square of the largest
// change that is left at a vertex, as the diagonal blocks have it.
double ElasticSurface::follow_direction(double step, double rz, double& largest) {
  double next = 0;
  largest = 0;
  for (const Index v : active_) {
    d_[v] += step * p_[v];
    r_[v] -= step * q_[v];
    z_[v] = times(inverse_[v], r_[v]);
    next += r_[v].dot(z_[v]);
    largest = std::max(largest, z_[v].squaredNorm());
  }
  const double share = rz > 0 ? next / rz : 0;
  for (const Index v : active_) p_[v] = z_[v] + share * p_[v];
  return next;
}

void ElasticSurface::minimize(std::span<const double> x, std::span<const double> target,
                              std::span<const NearPair> pairs, double stiffness,
                              const LinearTolerance& tolerance, std::span<double> out) {
  std::ranges::copy(target, out.begin());
  build_contacts(x, target, pairs, stiffness);
  for (const Index v : active_) d_[v] = at(x, v) - at(target, v);
  multiply(d_, q_);
  for (const Index v : active_) {
    r_[v] = rhs_[v] - q_[v];
    p_[v] = Vec3();
  }
  double largest = 0, rz = follow_direction(0, 0, largest);
  const double done =
      std::max(tolerance.change * tolerance.change, tolerance.share * tolerance.share * largest);
  for (int i = 0; i < kMaxIterations && rz > 0 && largest > done; ++i) {
    multiply(p_, q_);
    double along = 0;
    for (const Index v : active_) along += p_[v].dot(q_[v]);
    rz = follow_direction(rz / along, rz, largest);
  }
  for (const Index v : active_) put(out, v, at(target, v) + d_[v]);
}

}  // namespace foldproof
