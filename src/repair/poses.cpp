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

Frames::Kept* Frames::find(double time) {
  const auto found = std::ranges::find(kept_, time, &Kept::time);
  if (found == kept_.end()) return nullptr;
  found->used = ++uses_;
  return &*found;
}

Frames::Kept& Frames::make_room() {
  Kept& kept = *std::ranges::min_element(kept_, {}, &Kept::used);
  kept.time = -1;
  kept.used = ++uses_;
  kept.x.resize(scene_->size());
  return kept;
}

Result<std::span<const double>> Frames::read(Index k) {
  if (const Kept* kept = find(k)) return std::span<const double>(kept->x);
  Kept& kept = make_room();
  FOLDPROOF_TRY(input_->read(k, kept.x));
  for (std::size_t i = 0; i < kept.x.size(); ++i) {
    double& c = kept.x[i];
    if (!(std::abs(c) <= kMaxCoordinate)) {
      const auto vertex = static_cast<Index>(i / 3), object = scene_->object_of_vertex(vertex);
      return fail(
          std::isfinite(c) ? ErrorCode::LimitExceeded : ErrorCode::NonFinite,
          fmt::format("{}, frame {}, vertex {}", scene_->name(object), input_->first_frame + k,
                      vertex - scene_->begin(object).vertices),
          fmt::format("has the coordinate {:.3g}, and repair takes at most {:.0e}", c, kMaxCoordinate),
          "make the motion smaller, or leave the frame out");
    }
    if (single_precision_) c = static_cast<float>(c);
  }
  kept.time = k;
  return std::span<const double>(kept.x);
}

Result<std::span<const double>> Frames::at_time(double time) {
  const auto before = static_cast<Index>(time);
  if (time == before) return read(before);
  if (const Kept* kept = find(time)) return std::span<const double>(kept->x);
  const auto from = FOLDPROOF_TRY(read(before)), to = FOLDPROOF_TRY(read(before + 1));
  Kept& kept = make_room();
  for (std::size_t i = 0; i < kept.x.size(); ++i) {
    kept.x[i] = from[i] + (time - before) * (to[i] - from[i]);
    if (single_precision_) kept.x[i] = static_cast<float>(kept.x[i]);
  }
  kept.time = time;
  return std::span<const double>(kept.x);
}

void Smoother::add(std::span<const Correction> corrections, std::size_t k, bool loops, double negligible,
                   std::span<double> x) {
  const auto around = [&](int j) -> const Correction& {
    const auto last = static_cast<std::ptrdiff_t>(corrections.size()) - 1;
    const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(k) + j;
    return corrections[static_cast<std::size_t>(loops ? ((i % last) + last) % last
                                                      : std::clamp<std::ptrdiff_t>(i, 0, last))];
  };
  const auto weight = [](int j) { return std::exp(-0.5 * j * j / (kSigma * kSigma)); };
  double total = 0;
  for (int j = -kRadius; j <= kRadius; ++j) total += weight(j);
  for (int j = -kRadius; j <= kRadius; ++j) {
    const Correction& c = around(j);
    for (std::size_t i = 0; i < c.vertices.size(); ++i) {
      const Index v = c.vertices[i];
      put(sum_, v, at(sum_, v) + weight(j) / total * Vec3::load(&c.moved[3 * i]));
    }
  }
  for (int j = -kRadius; j <= kRadius; ++j) {
    for (const Index v : around(j).vertices) {
      const Vec3 d = at(sum_, v);
      if (d.norm() > negligible) put(x, v, at(x, v) + d);
      put(sum_, v, Vec3());
    }
  }
}

}  // namespace foldproof
