#include "solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "base/try.h"
#include "foldproof/solver.h"
#include "measure.h"

namespace foldproof::bench {
namespace {

using nlohmann::json;

constexpr double kHeight = 0.2;  // between sheets of size 1

// Two sheets with waves of a tenth, `height` apart.
struct Sheets {
  std::vector<double> x;
  std::vector<Triangle> faces;

  Sheets(Index side, double height) {
    for (const double z : {0.0, height}) {
      for (Index i = 0; i <= side; ++i) {
        for (Index k = 0; k <= side; ++k) {
          const double u = double(i) / side, v = double(k) / side;
          x.insert(x.end(), {u, v, z + 0.1 * std::cos(6 * u + 2) * std::sin(4 * v + 1)});
          if (i == side || k == side) continue;
          const auto a = static_cast<Index>(x.size() / 3 - 1), b = a + side + 1;
          faces.push_back({a, b, a + 1});
          faces.push_back({a + 1, b, b + 1});
        }
      }
    }
  }
  bool is_upper(std::size_t coordinate) const { return coordinate >= x.size() / 2; }
  Result<ContactChecker> checker() const {
    auto mesh = FOLDPROOF_TRY(CollisionMesh::make(x, {}, faces));
    return ContactChecker(std::make_shared<const CollisionMesh>(std::move(mesh)));
  }
};

// The fastest of three times, each with a checker of its own unless `kept` is given, which has answered
// before.
template <class Ask>
Result<json> measure(const Sheets& sheets, const SolverPlan& plan, bool kept, Ask ask) {
  json row;
  double fastest = std::numeric_limits<double>::infinity();
  auto checker = FOLDPROOF_TRY(sheets.checker());
  for (int round = 0; round < 3 + kept; ++round) {
    if (!kept) checker = FOLDPROOF_TRY(sheets.checker());
    const double start = now_milliseconds(plan.processor_time);
    const double answer = FOLDPROOF_TRY(ask(checker));
    const double took = now_milliseconds(plan.processor_time) - start;
    if (round >= int(kept)) fastest = std::min(fastest, took);
    row["answer"] = answer;
  }
  row["milliseconds"] = fastest;
  row["candidates"] = checker.work().candidates_vf + checker.work().candidates_ee;
  row["triangles"] = sheets.faces.size();
  return row;
}

// The sheets move by these along x, y and z: the lower one, then the upper one.
Result<json> measure_step(const SolverPlan& plan, const char* name, const Vec3& lower, const Vec3& upper) {
  const Sheets sheets(plan.side, kHeight);
  std::vector<double> end = sheets.x;
  for (std::size_t i = 0; i < end.size(); ++i) end[i] += (sheets.is_upper(i) ? upper : lower)[i % 3];
  const auto share_to = [&](const std::vector<double>& x1) {
    return [&](ContactChecker& checker) {
      return checker.collision_free_step_size(sheets.x, x1).map([](const foldproof::StepSize& size) {
        return size.share;
      });
    };
  };
  json row = FOLDPROOF_TRY(measure(sheets, plan, false, share_to(end)));
  row["question"] = name;
  const double share = row["answer"];
  if (share == 1) return row;
  std::vector<double> contact(end.size());  // a little beyond it
  step_towards(sheets.x, end, std::min(1.0, 1.3 * share), contact);
  row["until_contact"] = FOLDPROOF_TRY(measure(sheets, plan, false, share_to(contact)));
  return row;
}

Result<json> measure_distance(const SolverPlan& plan, double bound) {
  const Sheets sheets(plan.side, kHeight);
  json row = FOLDPROOF_TRY(measure(sheets, plan, false, [&](ContactChecker& checker) {
    return checker.minimum_distance(sheets.x, bound);
  }));
  row["question"] = "distance";
  row["bound"] = std::isfinite(bound) ? json(bound) : json("infinity");
  return row;
}

// `cells`: the height and the distance in cells.
Result<json> measure_close(const SolverPlan& plan, double height, double distance) {
  const Sheets sheets(plan.side, height / plan.side);
  std::vector<ClosePair> close;
  foldproof::Candidates near;
  json row = FOLDPROOF_TRY(measure(sheets, plan, true, [&](ContactChecker& checker) {
    return checker.close_pairs(sheets.x, distance / plan.side, close).map([&] {
      return double(close.size());
    });
  }));
  row["question"] = "close";
  row["height"] = height;
  row["distance"] = distance;
  row["of_candidates"] = FOLDPROOF_TRY(measure(sheets, plan, true, [&](ContactChecker& checker) {
    return checker.candidates(sheets.x, distance / plan.side, near).map([&] { return double(near.size()); });
  }));
  return row;
}

}  // namespace

Result<json> measure_solver(const SolverPlan& plan) {
  json rows = json::array();
  const auto add = [&](Result<json> row) -> Result<void> {
    rows.push_back(FOLDPROOF_TRY(std::move(row)));
    return {};
  };
  FOLDPROOF_TRY(add(measure_step(plan, "impact", {}, {0.3, 0.3, -1})));
  FOLDPROOF_TRY(add(measure_step(plan, "slide", {2, 1, 0}, {-2, -1, 0})));
  FOLDPROOF_TRY(add(measure_step(plan, "far", Vec3::Constant(1e6), Vec3::Constant(1e6))));
  for (const double bound : {0.01, 1.0, 1000.0, std::numeric_limits<double>::infinity()})
    FOLDPROOF_TRY(add(measure_distance(plan, bound)));
  for (const auto& [height, distance] : {std::pair(2.0, 0.2), std::pair(0.5, 0.6), std::pair(0.2, 0.3)})
    FOLDPROOF_TRY(add(measure_close(plan, height, distance)));
  return rows;
}

}  // namespace foldproof::bench
