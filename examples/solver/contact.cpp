#include "contact.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "foldproof/eigen.h"

namespace example {

using foldproof::Index;
using foldproof::Vec3;

namespace {

// Where on a segment the origin is nearest: 0 at p, 1 at q.
double nearest_on_segment(const Vec3& p, const Vec3& q) {
  const Vec3 side = q - p;
  const double length2 = side.squaredNorm();
  return length2 > 0 ? std::clamp(-p.dot(side) / length2, 0.0, 1.0) : 0;
}

struct Nearest {
  std::array<double, 4> weights{};
  double distance2 = std::numeric_limits<double>::infinity();
  void consider(const std::array<double, 4>& candidate, const std::array<Vec3, 4>& x) {
    Vec3 difference = Vec3::Zero();
    for (int k = 0; k < 4; ++k) difference += candidate[k] * x[k];
    if (difference.squaredNorm() < distance2) {
      distance2 = difference.squaredNorm();
      weights = candidate;
    }
  }
};

// The inside when the nearest point lies there, else the best of the sides.
std::array<double, 4> vertex_face_weights(const std::array<Vec3, 4>& x) {
  Nearest best;
  for (int k = 0; k < 3; ++k) {
    const int a = 1 + k, b = 1 + (k + 1) % 3;
    const double s = nearest_on_segment(x[a] - x[0], x[b] - x[0]);
    std::array<double, 4> weights{1, 0, 0, 0};
    weights[a] = s - 1;
    weights[b] = -s;
    best.consider(weights, x);
  }
  Eigen::Matrix<double, 3, 2> sides;
  sides << to_eigen(x[2] - x[1]), to_eigen(x[3] - x[1]);
  const Eigen::Vector2d st =
      (sides.transpose() * sides).ldlt().solve(sides.transpose() * to_eigen(x[0] - x[1]));
  if (st.minCoeff() >= 0 && st.sum() <= 1) best.consider({1, st.sum() - 1, -st[0], -st[1]}, x);
  return best.weights;
}

std::array<double, 4> edge_edge_weights(const std::array<Vec3, 4>& x) {
  Nearest best;
  for (int k = 0; k < 2; ++k) {
    const double t = nearest_on_segment(x[2] - x[k], x[3] - x[k]);
    best.consider({double(k == 0), double(k == 1), t - 1, -t}, x);
    const double s = nearest_on_segment(x[0] - x[2 + k], x[1] - x[2 + k]);
    best.consider({1 - s, s, -double(k == 0), -double(k == 1)}, x);
  }
  const Vec3 a = x[1] - x[0], b = x[3] - x[2], r = x[0] - x[2];
  const double aa = a.dot(a), ab = a.dot(b), bb = b.dot(b), determinant = aa * bb - ab * ab;
  if (determinant > 1e-12 * aa * bb) {
    const double s = (ab * b.dot(r) - bb * a.dot(r)) / determinant;
    const double t = (aa * b.dot(r) - ab * a.dot(r)) / determinant;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) best.consider({1 - s, s, t - 1, -t}, x);
  }
  return best.weights;
}

}  // namespace

void find_contacts(const foldproof::CollisionMesh& mesh, const foldproof::Candidates& candidates,
                   std::span<const double> x, double reach, std::vector<Contact>& out) {
  out.clear();
  const auto look = [&](const std::array<Index, 4>& vertices, auto weights_of) {
    std::array<Vec3, 4> points;
    for (int k = 0; k < 4; ++k) points[k] = Vec3::load(&x[3 * std::size_t{vertices[k]}]);
    Contact contact{vertices, weights_of(points), Vec3::Zero(), 0};
    for (int k = 0; k < 4; ++k) contact.normal += contact.weights[k] * points[k];
    contact.distance = contact.normal.norm();
    if (contact.distance >= reach) return;
    contact.normal /= contact.distance;
    out.push_back(contact);
  };
  for (const auto& [vertex, face] : candidates.vertex_face) {
    const auto& f = mesh.faces()[face];
    look({vertex, f[0], f[1], f[2]}, vertex_face_weights);
  }
  for (const auto& [edge_a, edge_b] : candidates.edge_edge) {
    const auto &a = mesh.edges()[edge_a], &b = mesh.edges()[edge_b];
    look({a[0], a[1], b[0], b[1]}, edge_edge_weights);
  }
}

double Barrier::value(double d) const {
  const double y = d / reach;
  return -stiffness * (y - 1) * (y - 1) * std::log(y);
}

double Barrier::slope(double d) const {
  const double y = d / reach;
  return -stiffness / reach * (2 * (y - 1) * std::log(y) + (y - 1) * (y - 1) / y);
}

double Barrier::curvature(double d) const {
  const double y = d / reach;
  return -stiffness / (reach * reach) * (2 * std::log(y) + 4 * (y - 1) / y - (y - 1) * (y - 1) / (y * y));
}

}  // namespace example
