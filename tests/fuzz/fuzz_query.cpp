// Any bytes are the decisions of the adversary's generator: a small scene in motion, asked in every way there
// is and held against exact arithmetic.
#include <fmt/format.h>

#include <cstdlib>

#include "adversary/run.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace foldproof::adversary;
  Source source(std::span(data, size));
  const Case c = make_case(source);
  Tally tally;
  const std::string wrong = run_case(c, tally);
  if (wrong.empty()) return 0;
  fmt::print(stderr, "{}\n{}", wrong, describe(cut_down(c)));
  std::abort();
}
