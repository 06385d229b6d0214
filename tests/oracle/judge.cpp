#include "oracle/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace foldproof::oracle {
namespace {

// Largest coordinate of the difference of two points, one of each feature, at either end of the step.
double extent(Kind kind, const FourPoints& x0, const FourPoints& x1) {
  const int of_first = kind == Kind::VertexFace ? 1 : 2;
  double result = 0;
  for (const FourPoints* x : {&x0, &x1}) {
    for (int i = 0; i < of_first; ++i) {
      for (int k = of_first; k < 4; ++k) {
        result = std::max(result, ((*x)[i] - (*x)[k]).cwiseAbs().maxCoeff());
      }
    }
  }
  return result;
}

bool in_contact(Kind kind, const FourPoints& x0, const FourPoints& x1, double thickness, const Span& span) {
  if (thickness == 0) return touches(kind, x0, x1, span);
  const double margin = std::max(std::ldexp(extent(kind, x0, x1), -40), 0x1p-1074);
  return approach(kind, x0, x1, thickness, margin, span) == Approach::Within;
}

}  // namespace

CcdResult narrow_phase(Kind kind, const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings) {
  return kind == Kind::VertexFace ? vertex_face_ccd(x0, x1, settings) : edge_edge_ccd(x0, x1, settings);
}

double allowed_tolerance(Kind kind, const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings) {
  return std::max(settings.tolerance, ccd_resolution(extent(kind, x0, x1)));
}

Verdict judge(Kind kind, const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings,
              const CcdResult& result) {
  Verdict verdict;
  verdict.touched = in_contact(kind, x0, x1, settings.thickness, {settings.latest, false});
  if (result.answer == Answer::Separated) {
    if (verdict.touched) verdict.complaint = "missed: the features touch, and the answer is Separated";
    return verdict;
  }
  if (!(result.toi >= 0 && result.toi <= settings.latest)) {
    verdict.complaint = fmt::format("toi {} is not in [0, latest]", result.toi);
    return verdict;
  }
  if (in_contact(kind, x0, x1, settings.thickness, {result.toi, true})) {
    verdict.complaint = fmt::format("late: the features touch before toi {:a}", result.toi);
    return verdict;
  }
  const double tolerance = allowed_tolerance(kind, x0, x1, settings);
  const Rational bound = Rational(settings.thickness) + Rational(tolerance);
  if (result.answer == Answer::Hit && !within_distance(kind, x0, x1, result.toi, bound)) {
    const Rational square = squared_distance(kind, x0, x1, result.toi);
    verdict.complaint =
        fmt::format("out of tolerance: distance {} at toi {:a}, thickness {}, tolerance {}",
                    std::sqrt(square.convert_to<double>()), result.toi, settings.thickness, tolerance);
  }
  return verdict;
}

std::string describe(Kind kind, const FourPoints& x0, const FourPoints& x1, const CcdSettings& settings) {
  std::string text = kind == Kind::VertexFace ? "vertex-face" : "edge-edge";
  for (const FourPoints* x : {&x0, &x1}) {
    text += x == &x0 ? "\n  x0 = {" : "\n  x1 = {";
    for (const Vec3& p : *x) text += fmt::format("Vec3({:a}, {:a}, {:a}), ", p.x(), p.y(), p.z());
    text += "}";
  }
  return text + fmt::format("\n  thickness {:a}, tolerance {:a}, latest {:a}, max_iterations {}",
                            settings.thickness, settings.tolerance, settings.latest, settings.max_iterations);
}

}  // namespace foldproof::oracle
