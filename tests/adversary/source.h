/// Where the decisions of a case come from: a seed, or the bytes of a fuzzer and then a fixed seed.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <span>

namespace foldproof::adversary {

class Source {
 public:
  explicit Source(std::uint64_t seed) : rng_(seed) {}
  explicit Source(std::span<const std::uint8_t> bytes) : bytes_(bytes), rng_(1) {}

  /// 0 .. count - 1; count <= 65536.
  unsigned pick(unsigned count) {
    if (bytes_.empty()) return static_cast<unsigned>(rng_() % count);
    return (count <= 256 ? byte() : 256 * byte() + byte()) % count;
  }
  bool one_in(unsigned count) { return pick(count) == 0; }
  /// Between both.
  double real(double low, double high) {
    const double share = bytes_.empty() ? std::ldexp(static_cast<double>(rng_() >> 11), -53)
                                        : (256 * byte() + byte()) / 65535.0;
    return low + share * (high - low);
  }
  /// The same on a logarithmic scale; both are positive.
  double spread(double low, double high) { return std::exp(real(std::log(low), std::log(high))); }
  /// An integer, both included.
  int whole(int low, int high) { return low + static_cast<int>(pick(static_cast<unsigned>(high - low + 1))); }
  double sign() { return one_in(2) ? -1 : 1; }

 private:
  unsigned byte() {
    if (bytes_.empty()) return static_cast<unsigned>(rng_() & 255);
    const unsigned value = bytes_.front();
    bytes_ = bytes_.subspan(1);
    return value;
  }
  std::span<const std::uint8_t> bytes_;
  std::mt19937_64 rng_;
};

}  // namespace foldproof::adversary
