// Prints: free: 1, contacts before: 2
// The nearest motion that touches nothing: a triangle is pressed 0.2 through another, and back.
#include "foldproof/repair.h"

#include <cmath>
#include <cstdio>

int main() {
  using namespace foldproof;
  // Two triangles above each other; the second goes down and up again.
  const auto topology = Topology::make(6, {{0, 1, 2}, {3, 4, 5}}).value();
  const std::vector<double> rest{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.3, 1, 0, 0.3, 0, 1, 0.3};
  RepairInput input;
  input.objects.push_back({Hierarchy::build(topology, rest).value()});
  input.frame_count = 11;
  input.read = [&](Index k, std::span<double> x) -> Result<void> {
    std::copy(rest.begin(), rest.end(), x.begin());
    for (const int z : {11, 14, 17}) x[z] -= 0.5 * (1 - std::abs(k / 5.0 - 1));
    return {};
  };
  const auto report = repair(input, {}, [](double, std::span<const double>) -> Result<void> {
                        return {};  // here the frame is written
                      }).value();
  std::printf("free: %d, contacts before: %zu\n", report.free, report.before.size());
}
