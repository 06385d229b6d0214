#include "contact.h"

#include <cmath>

namespace example {

double Barrier::value(double d) const {
  const double y = d / reach;
  if (y >= 1) return 0;
  return -stiffness * (y - 1) * (y - 1) * std::log(y);
}

double Barrier::slope(double d) const {
  const double y = d / reach;
  if (y >= 1) return 0;
  return -stiffness / reach * (2 * (y - 1) * std::log(y) + (y - 1) * (y - 1) / y);
}

double Barrier::curvature(double d) const {
  const double y = d / reach;
  if (y >= 1) return 0;
  return -stiffness / (reach * reach) * (2 * std::log(y) + 4 * (y - 1) / y - (y - 1) * (y - 1) / (y * y));
}

}  // namespace example
