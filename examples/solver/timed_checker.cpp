#include "timed_checker.h"

#include <algorithm>
#include <ctime>

namespace example {
namespace {

foldproof::ContactSettings with_certificates(bool on) {
  foldproof::ContactSettings settings;
  settings.certificates = on;
  return settings;
}

bool same(std::span<const Contact> a, std::span<const Contact> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Contact& s, const Contact& t) {
    return s.vertices == t.vertices && s.distance == t.distance;
  });
}

double share_of(const foldproof::StepSize& size) { return size.share; }

}  // namespace

double processor_time() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

TimedChecker::TimedChecker(std::shared_ptr<const foldproof::CollisionMesh> mesh)
    : mesh_(std::move(mesh)),
      checkers_{foldproof::ContactChecker(mesh_, with_certificates(true)),
                foldproof::ContactChecker(mesh_, with_certificates(false))} {}

template <class Ask>
auto TimedChecker::ask_both(Ask ask) {
  const double start = processor_time();
  const auto with = ask(checkers_[0]);
  const double middle = processor_time();
  const auto without = ask(checkers_[1]);
  seconds_[0] += middle - start;
  seconds_[1] += processor_time() - middle;
  disagreements_ += !with || !without || *with != *without;
  return with.value();
}

double TimedChecker::step_size(std::span<const double> x0, std::span<const double> x1) {
  return ask_both([&](auto& checker) { return checker.collision_free_step_size(x0, x1).map(share_of); });
}

bool TimedChecker::step_is_free(std::span<const double> x0, std::span<const double> x1) {
  return ask_both([&](auto& checker) { return checker.is_step_collision_free(x0, x1).result(); });
}

bool TimedChecker::intersects(std::span<const double> x) {
  return ask_both([&](auto& checker) { return checker.has_intersections(x).result(); });
}

void TimedChecker::contacts(std::span<const double> x, double reach, std::vector<Contact>& out) {
  for (const int k : {1, 0}) {
    std::vector<Contact>& found = k == 0 ? out : other_;
    const double start = processor_time();
    if (!checkers_[k].close_pairs(x, reach, found)) ++disagreements_;
    seconds_[k] += processor_time() - start;
  }
  const double start = processor_time();
  disagreements_ += !same(out, other_);
  seconds_compared_ += processor_time() - start;
}

}  // namespace example
