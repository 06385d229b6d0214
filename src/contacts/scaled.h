/// Positions whose products neither overflow nor underflow.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "foldproof/contacts.h"

namespace foldproof::inline internal {

/// Positions, divided by a power of two where their coordinates are so large or so small that lengths could
/// not be computed. Else the same.
class Scaled {
 public:
  explicit Scaled(Positions x) : x_(x) {
    double largest = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (const double c : x[i]) largest = std::max(largest, std::abs(c));
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    if (std::abs(exponent) <= 200) return;
    exponent_ = exponent;
    for (std::size_t i = 0; i < x.size(); ++i) {
      auto& copy = copies_.emplace_back(x[i].begin(), x[i].end());
      for (double& c : copy) c = std::ldexp(c, -exponent_);
    }
    spans_.assign(copies_.begin(), copies_.end());
    x_ = spans_;
  }
  Scaled(const Scaled&) = delete;
  Scaled& operator=(const Scaled&) = delete;

  Positions positions() const { return x_; }

  /// Multiply what was measured on positions() by the power of two.
  void restore(ContactFrame& frame) const {
    frame.curve_length = std::ldexp(frame.curve_length, exponent_);
    if (frame.depth) frame.depth = std::ldexp(*frame.depth, exponent_);
    for (auto& area : frame.area) {
      if (area) area = std::ldexp(*area, 2 * exponent_);
    }
  }
  void restore(Contact& contact) const {
    restore(contact.point);
    restore(contact.low);
    restore(contact.high);
    for (auto& curve : contact.curves) {
      for (Vec3& p : curve) restore(p);
    }
  }

 private:
  void restore(Vec3& p) const {
    for (double& c : p) c = std::ldexp(c, exponent_);
  }

  Positions x_;
  int exponent_ = 0;
  std::vector<std::vector<double>> copies_;
  std::vector<std::span<const double>> spans_;
};

}  // namespace foldproof::inline internal
