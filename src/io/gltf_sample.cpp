// Interpolation between the keys of an animation (glTF 2.0 specification, appendix C).
#include <cmath>

#include "io/gltf_frames.h"

namespace foldproof::io {
namespace {

/// Spherical interpolation along the shorter arc.
void slerp(std::span<const double> from, std::span<const double> to, double s, std::span<double> out) {
  const Eigen::Quaterniond a(Eigen::Map<const Eigen::Vector4d>(from.data()));
  const Eigen::Quaterniond b(Eigen::Map<const Eigen::Vector4d>(to.data()));
  Eigen::Map<Eigen::Vector4d>(out.data()) = a.normalized().slerp(s, b.normalized()).coeffs();
}

/// The keys before and after a time; the same key twice where its value holds.
std::pair<std::uint64_t, std::uint64_t> find_keys(const GltfAccessor& times, double time) {
  const std::uint64_t keys = times.count();
  std::uint64_t next = 0;  // the first key after `time`
  for (std::uint64_t high = keys; next < high;) {
    const std::uint64_t probe = (next + high) / 2;
    if (times.get(probe, 0) <= time) {
      next = probe + 1;
    } else {
      high = probe;
    }
  }
  if (next == 0) return {0, 0};
  if (next == keys) return {keys - 1, keys - 1};
  const double before = time - times.get(next - 1, 0), after = times.get(next, 0) - time;
  const std::uint64_t nearest = after < before ? next : next - 1;
  if (is_time_of_key(time, times.get(nearest, 0))) return {nearest, nearest};
  return {next - 1, next};
}

}  // namespace

void sample_channel(const GltfChannel& channel, double time, std::span<double> out) {
  const bool cubic = channel.interpolation == GltfInterpolation::CubicSpline;
  // A key has one element for a transform, one per target for weights. A spline stores in-tangent, value and
  // out-tangent.
  const bool scalars = channel.path == GltfPath::Weights;
  const std::uint64_t elements = scalars ? out.size() : 1;
  const auto value = [&](std::uint64_t key, std::uint64_t part, std::size_t i) {
    const std::uint64_t element = (key * (cubic ? 3 : 1) + part) * elements;
    return scalars ? channel.values.get(element + i, 0) : channel.values.get(element, static_cast<int>(i));
  };
  const std::uint64_t value_part = cubic ? 1 : 0;
  const auto [key, next] = find_keys(channel.times, time);
  if (key == next || channel.interpolation == GltfInterpolation::Step) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = value(key, value_part, i);
    return;
  }
  const double t0 = channel.times.get(key, 0), interval = channel.times.get(next, 0) - t0;
  const double s = (time - t0) / interval;
  if (channel.path == GltfPath::Rotation && !cubic) {
    std::array<double, 4> from, to;
    for (std::size_t i = 0; i < 4; ++i) {
      from[i] = value(key, 0, i);
      to[i] = value(next, 0, i);
    }
    slerp(from, to, s, out);
    return;
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double a = value(key, value_part, i), b = value(next, value_part, i);
    if (!cubic) {
      out[i] = a + s * (b - a);
      continue;
    }
    const double out_tangent = interval * value(key, 2, i), in_tangent = interval * value(next, 0, i);
    const double s2 = s * s, s3 = s2 * s;
    out[i] = (2 * s3 - 3 * s2 + 1) * a + (s3 - 2 * s2 + s) * out_tangent + (3 * s2 - 2 * s3) * b +
             (s3 - s2) * in_tangent;
  }
}

}  // namespace foldproof::io
