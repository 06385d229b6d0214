#include "families.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>

#include <nlohmann/json.hpp>

#include "base/try.h"
#include "foldproof/check.h"
#include "measure.h"

namespace foldproof::bench {
namespace {

using nlohmann::json;

constexpr int kSteps = 5, kSizes = 3, kRounds = 3;
constexpr double kTurn = 2 * std::numbers::pi;

/// Triangles, and where a vertex is at a time from 0 to 1.
struct Shape {
  std::vector<Triangle> triangles;
  Index vertices;
  std::function<Vec3(Index vertex, double t)> place;
};

struct Family {
  const char* name;
  Index smallest;
  Shape (*make)(Index size);
};

Vec3 on_circle(double turns) { return {std::cos(kTurn * turns), std::sin(kTurn * turns), 0}; }

// Vertex 0 with triangles around it. The rim goes up and down by `height`, and grows.
Shape fan(Index size, double height) {
  Shape shape{{}, size + 1, nullptr};
  for (Index i = 0; i < size; ++i) shape.triangles.push_back({0, 1 + i, 1 + (i + 1) % size});
  shape.place = [=](Index v, double t) {
    if (v == 0) return Vec3(0, 0, -0.5 * (height > 0));
    const double turns = static_cast<double>(v - 1) / size;
    const Vec3 rim = on_circle(turns) * (1 + 0.1 * t);
    return Vec3(rim.x(), rim.y(), height * std::sin(kTurn * (5 * turns + t)));
  };
  return shape;
}
Shape cone(Index size) { return fan(size, 0.1); }
Shape flat_fan(Index size) { return fan(size, 0); }

// A polygon as files have it: a fan from its first corner.
Shape polygon(Index size, double tilt) {
  Shape shape{{}, size, nullptr};
  for (Index i = 2; i < size; ++i) shape.triangles.push_back({0, i - 1, i});
  shape.place = [=](Index v, double t) {
    const Vec3 p = on_circle(static_cast<double>(v) / size) * (1 + 0.1 * t);
    return Vec3(p.x(), p.y(), tilt * (p.x() + 0.37 * p.y()));
  };
  return shape;
}
Shape flat_polygon(Index size) { return polygon(size, 0); }
Shape tilted_polygon(Index size) { return polygon(size, 0.3); }

// Pages at an edge, which turn about it. They come in the order of their angles, or in none.
Shape book_in_order(std::vector<Index> order) {
  const auto size = static_cast<Index>(order.size());
  Shape shape{{}, size + 2, nullptr};
  for (const Index page : order) shape.triangles.push_back({0, 1, 2 + page});
  shape.place = [=](Index v, double t) {
    if (v < 2) return Vec3(0, 0, v == 0 ? -1 : 1);
    return on_circle((0.8 + 0.1 * t) * (v - 2) / size);
  };
  return shape;
}
Shape book(Index size) {
  std::vector<Index> order(size);
  std::iota(order.begin(), order.end(), Index{0});
  return book_in_order(std::move(order));
}
Shape shuffled_book(Index size) {
  std::vector<Index> order(size);
  std::iota(order.begin(), order.end(), Index{0});
  std::mt19937 random(1);
  for (Index i = size; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  return book_in_order(std::move(order));
}

// Triangles of their own around a vertex, in all directions.
Shape burr(Index size) {
  Shape shape{{}, 2 * size + 1, nullptr};
  for (Index i = 0; i < size; ++i) shape.triangles.push_back({0, 1 + 2 * i, 2 + 2 * i});
  shape.place = [=](Index v, double t) {
    if (v == 0) return Vec3(0, 0, 0);
    // Along a spiral on the sphere, each as wide as the half of the distance to the next.
    const double along = (v - 1) / 2 + 0.5, height = 1 - 2 * along / size;
    const double side = (v % 2 == 0 ? 0.5 : -0.5) * std::sqrt(std::numbers::pi / size);
    const double turns = along * (std::numbers::phi - 1) + 0.01 * t;
    const Vec3 out = on_circle(turns), radial = out * std::sqrt(1 - height * height) + Vec3(0, 0, height);
    return radial + Vec3(-out.y(), out.x(), 0) * side;
  };
  return shape;
}

// One triangle many times, with the same vertices or with its own.
Shape copies(Index size) {
  return {std::vector<Triangle>(size, {0, 1, 2}), 3,
          [](Index v, double t) { return on_circle(v / 3.0) + Vec3(0, 0, t); }};
}
Shape duplicates(Index size) {
  Shape shape{{}, 3 * size, [](Index v, double t) { return on_circle(v % 3 / 3.0) + Vec3(0, 0, t); }};
  for (Index i = 0; i < size; ++i) shape.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  return shape;
}

constexpr Family kFamilies[] = {{"cone", 4'000, cone},
                                {"flat fan", 4'000, flat_fan},
                                {"flat polygon", 1'000, flat_polygon},
                                {"tilted polygon", 1'000, tilted_polygon},
                                {"book", 1'000, book},
                                {"shuffled book", 1'000, shuffled_book},
                                {"burr", 4'000, burr},
                                {"copies", 4'000, copies},
                                {"duplicates", 250, duplicates}};

struct Timed {
  double size, milliseconds;
};

/// A family of one size: the first pose, and a step.
Result<std::array<Timed, 2>> measure_shape(const Shape& shape, bool processor_time) {
  std::vector<std::vector<double>> frames(kSteps + 1);
  for (int k = 0; k <= kSteps; ++k) {
    for (Index v = 0; v < shape.vertices; ++v) {
      const Vec3 p = shape.place(v, static_cast<double>(k) / kSteps);
      frames[k].insert(frames[k].end(), p.begin(), p.end());
    }
  }
  auto topology = FOLDPROOF_TRY(Topology::make(shape.vertices, shape.triangles));
  const auto tree =
      std::make_shared<const Hierarchy>(FOLDPROOF_TRY(Hierarchy::build(std::move(topology), frames[0])));
  StepSettings settings;
  settings.max_listed = 1000;
  const auto triangles = static_cast<double>(shape.triangles.size());
  Timed pose{triangles, INFINITY}, step{triangles, INFINITY};
  StaticResult crossings;
  StepResult collisions;
  for (int round = 0; round < kRounds; ++round) {
    StepChecker first({tree}), moving({tree});
    const double start = now_milliseconds(processor_time);
    FOLDPROOF_TRY(first.check_static(frames[0], settings, crossings));
    const double between = now_milliseconds(processor_time);
    pose.milliseconds = std::min(pose.milliseconds, between - start);
    std::uint64_t answers = 0;
    for (int k = 0; k < kSteps; ++k) {
      FOLDPROOF_TRY(moving.check(frames[k], frames[k + 1], settings, collisions));
      answers += collisions.vertex_face_count + collisions.edge_edge_count;
    }
    step.milliseconds = std::min(step.milliseconds, (now_milliseconds(processor_time) - between) / kSteps);
    step.size = triangles + static_cast<double>(answers) / kSteps;
    pose.size = triangles + static_cast<double>(crossings.crossing_count);
    if (pose.milliseconds + step.milliseconds > 2000) break;  // too long to be off by much
  }
  return std::array{pose, step};
}

}  // namespace

Result<json> measure_families(bool processor_time) {
  json rows = json::array();
  for (const Family& family : kFamilies) {
    std::array<std::array<Timed, 2>, kSizes> timed;
    for (int k = 0; k < kSizes; ++k)
      timed[k] = FOLDPROOF_TRY(measure_shape(family.make(family.smallest << k), processor_time));
    for (const std::size_t moves : {0, 1}) {
      const Timed &least = timed.front()[moves], &most = timed.back()[moves];
      const double exponent =
          std::log(most.milliseconds / least.milliseconds) / std::log(most.size / least.size);
      json row = {{"name", family.name}, {"step", moves ? "full" : "first pose"}, {"exponent", exponent}};
      for (int k = 0; k < kSizes; ++k)
        row["sizes"].push_back(
            {{"size", timed[k][moves].size}, {"milliseconds", timed[k][moves].milliseconds}});
      fmt::print(stderr, "{:<17}{:<17}{:9.3f} ms at size {:.0f}, exponent {:.2f}\n", family.name,
                 row["step"].get<std::string>(), most.milliseconds, most.size, exponent);
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace foldproof::bench
