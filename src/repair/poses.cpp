#include "repair/poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/try.h"

namespace foldproof {
namespace {

constexpr double kSigma = 1.5;  // of the Gaussian, in frames
// Corrections are kept in single precision, and squares of lengths added.
constexpr double kMaxCoordinate = 1e30;

}  // namespace

Correction Correction::between(std::span<const double> frame, std::span<const double> x) {
  Correction out;
  for (Index v = 0; v < frame.size() / 3; ++v) {
    const Vec3 from = at(frame, v), to = at(x, v);
    if (from == to) continue;
    out.vertices.push_back(v);
    out.x.insert(out.x.end(), to.begin(), to.end());
    for (const double c : to - from) out.moved.push_back(static_cast<float>(c));
    out.largest = std::max(out.largest, (to - from).norm());
  }
  return out;
}

void Correction::apply(std::span<double> frame) const {
  for (std::size_t i = 0; i < vertices.size(); ++i) put(frame, vertices[i], Vec3::load(&x[3 * i]));
}

Result<std::vector<double>> Frames::read(Index k) const {
  std::vector<double> x(scene_->size());
  FOLDPROOF_TRY(input_->read(k, x));
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::abs(x[i]) <= kMaxCoordinate) continue;
    const auto vertex = static_cast<Index>(i / 3), object = scene_->object_of_vertex(vertex);
    return fail(
        std::isfinite(x[i]) ? ErrorCode::LimitExceeded : ErrorCode::NonFinite,
        fmt::format("{}, frame {}, vertex {}", scene_->name(object), input_->first_frame + k,
                    vertex - scene_->begin(object).vertices),
        fmt::format("has the coordinate {:.3g}, and repair takes at most {:.0e}", x[i], kMaxCoordinate),
        "make the motion smaller, or leave the frame out");
  }
  if (single_precision_) round_to_single(x);
  return x;
}

Result<std::vector<double>> Frames::at_time(double time) const {
  const auto before = static_cast<Index>(time);
  auto x = FOLDPROOF_TRY(read(before));
  if (time == before) return x;
  const auto to = FOLDPROOF_TRY(read(before + 1));
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += (time - before) * (to[i] - x[i]);
  if (single_precision_) round_to_single(x);
  return x;
}

void internal::add_average(std::span<const Correction> corrections, std::size_t k, bool loops,
                           double negligible, std::span<double> x) {
  const auto last = static_cast<std::ptrdiff_t>(corrections.size()) - 1;
  const auto weight = [](int j) { return std::exp(-0.5 * j * j / (kSigma * kSigma)); };
  double total = 0;
  for (int j = -kSmoothingRadius; j <= kSmoothingRadius; ++j) total += weight(j);
  std::vector<double> sum(x.size());
  for (int j = -kSmoothingRadius; j <= kSmoothingRadius; ++j) {
    const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(k) + j;
    const auto around = loops ? ((i % last) + last) % last : std::clamp<std::ptrdiff_t>(i, 0, last);
    const Correction& c = corrections[static_cast<std::size_t>(around)];
    for (std::size_t n = 0; n < c.vertices.size(); ++n) {
      const Index v = c.vertices[n];
      put(sum, v, at(sum, v) + weight(j) / total * Vec3::load(&c.moved[3 * n]));
    }
  }
  for (Index v = 0; v < x.size() / 3; ++v) {
    if (const Vec3 d = at(sum, v); d.norm() > negligible) put(x, v, at(x, v) + d);
  }
}

}  // namespace foldproof
