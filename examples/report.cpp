// Prints: 0 crossings at the start, 11 steps, collisions in the last 3; the rest is in strip.json
// Checks a whole motion and writes a report.
#include "foldproof/report.h"

#include <cstdio>

#include "strip.h"

int main() {
  using namespace foldproof;
  std::vector<std::unique_ptr<Motion>> motions;
  motions.push_back(bending_strip(0.1, 8, 12));
  std::vector<std::unique_ptr<ReportWriter>> writers;
  auto json = json_report("strip.json", motions, {.settings = {}, .read = {}, .pairs = true});
  if (!json) return std::puts(json.error().line().c_str()), 1;
  writers.push_back(std::move(*json));
  const auto totals = run_check(motions, {}, writers);
  if (!totals) return std::puts(totals.error().line().c_str()), 1;
  std::printf(
      "%lu crossings at the start, %lu steps, collisions in the last %lu; the rest is in strip.json\n",
      totals->starts_crossing.value_or(0), totals->steps, totals->steps_with_collisions);
}
