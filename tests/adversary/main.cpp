// Looks for answers that are wrong, or differ where they may not, in small scenes of parts whose sizes differ
// by up to a million. Finding one is a failure.
#include <fmt/format.h>
#include <sys/time.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "adversary/run.h"
#include "adversary/touching.h"

namespace foldproof::adversary {
namespace {

// Of processor time, for a question. It takes milliseconds, or a second if 20,000 pairs collide; a case may
// ask hundreds of questions.
constexpr long kMaxSeconds = 20;

struct Options {
  double seconds = 10;
  std::uint64_t seed = 1;
  std::uint64_t first = 0;
  bool single = false;
};

volatile std::uint64_t now_seed = 0, now_case = 0;

// Nothing but what a signal handler may do; fmt's buffer is on the stack.
void give_up(int signal) {
  char text[200];
  const int size = std::snprintf(
      text, sizeof text, "case %llu of seed %llu %s in %s; repeat it with --seed %llu --case %llu\n",
      static_cast<unsigned long long>(now_case), static_cast<unsigned long long>(now_seed),
      signal == SIGVTALRM ? "does not end" : "crashes", question, static_cast<unsigned long long>(now_seed),
      static_cast<unsigned long long>(now_case));
  if (write(STDOUT_FILENO, text, static_cast<std::size_t>(size)) < 0) _exit(2);
  _exit(1);
}

// Called after every kMaxSeconds. Gives up if no new question was asked since the last call.
void look_for_progress(int signal) {
  static volatile std::uint64_t last = 0;
  const std::uint64_t now = questions_asked;
  if (now == last) give_up(signal);
  last = now;
}

// Calls look_for_progress whenever so many seconds of processor time have passed; 0: never.
void look_every(long seconds) {
  const itimerval time = {{seconds, 0}, {seconds, 0}};
  setitimer(ITIMER_VIRTUAL, &time, nullptr);
}

Source numbered(std::uint64_t seed, std::uint64_t number) {
  return Source(seed * 0x9E3779B97F4A7C15u + number * 0xD1B54A32D192ED03u);
}

bool read_options(int argc, char** argv, Options& options) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    char* end = nullptr;
    if (name == "--seconds") {
      options.seconds = std::strtod(argv[i + 1], &end);
    } else if (name == "--seed") {
      options.seed = std::strtoull(argv[i + 1], &end, 10);
    } else if (name == "--case") {
      options.first = std::strtoull(argv[i + 1], &end, 10);
      options.single = true;
    } else {
      return false;
    }
    if (end == argv[i + 1] || *end != '\0') return false;
  }
  return argc % 2 == 1;
}

void print(const Tally& t, double seconds) {
  fmt::print(
      "{} cases, {} steps in {:.0f} s ({:.0f} a second); {:.1f} % of the steps collide, in {} pairs, "
      "{} undecided; {} steps were served by a search ahead; {} poses, {:.1f} % cross; {} calls of a solver; "
      "{} reduced steps; {} single pairs; exact arithmetic was asked {} times\n",
      t.cases, t.steps, seconds, t.steps / seconds, 100.0 * t.hit_steps / std::max<std::uint64_t>(t.steps, 1),
      t.collisions, t.undecided, t.served, t.poses, 100.0 * t.hit_poses / std::max<std::uint64_t>(t.poses, 1),
      t.solver_calls, t.reduced_steps, t.touching, t.asked);
}

// Otherwise nothing was tested.
bool worth_while(const Tally& t) {
  if (t.cases < 1000) return true;
  const double hits = static_cast<double>(t.hit_steps) / static_cast<double>(t.steps);
  return hits > 0.05 && hits < 0.7 && t.served > 0 && t.solver_calls > 0 && t.reduced_steps > 0 &&
         t.hit_poses > 0;
}

int search(const Options& options) {
  // Of the processor: what is found does not depend on who else is at work.
  const auto seconds = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  Tally tally;
  now_seed = options.seed;
  look_every(kMaxSeconds);
  for (std::uint64_t number = options.first;
       options.single ? number == options.first : seconds() < options.seconds; ++number) {
    now_case = number;
    Source source = numbered(options.seed, number);
    const Case c = make_case(source);
    const std::string scene = run_case(c, tally), wrong = scene.empty() ? ask_touching(source, tally) : scene;
    if (wrong.empty()) continue;
    fmt::print("case {} of seed {} after {:.1f} s: {}\nrepeat it with --seed {} --case {}\n\n", number,
               options.seed, seconds(), wrong, options.seed, number);
    std::fflush(stdout);
    if (scene.empty()) return 1;
    look_every(0);
    const Case small = cut_down(c);
    Tally unused;
    fmt::print("cut down: {}\n{}", run_case(small, unused), describe(small));
    return 1;
  }
  look_every(0);
  print(tally, seconds());
  if (worth_while(tally)) return 0;
  fmt::print("the cases do not test what they should: see the shares above\n");
  return 1;
}

}  // namespace
}  // namespace foldproof::adversary

int main(int argc, char** argv) {
  using namespace foldproof::adversary;
  Options options;
  if (!read_options(argc, argv, options)) {
    fmt::print(stderr,
               "usage: adversary [--seconds S] [--seed N] [--case N]; seconds are the processor's; --case "
               "repeats one\n");
    return 2;
  }
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE}) std::signal(signal, give_up);
  std::signal(SIGVTALRM, look_for_progress);
  return search(options);
}
