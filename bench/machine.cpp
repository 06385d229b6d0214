#include "machine.h"

#include <sched.h>
#include <sys/utsname.h>

#include <ctime>
#include <fstream>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "foldproof/base.h"

namespace foldproof::bench {
namespace {

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  std::map<std::string, std::string> facts;
  for (std::string line; std::getline(info, line);) {
    const auto colon = line.find(':');
    if (colon == std::string::npos) continue;
    const std::string key = line.substr(0, line.find_last_not_of(" \t", colon - 1) + 1);
    facts.try_emplace(key, line.substr(std::min(line.size(), colon + 2)));
  }
  return fmt::format("{} (family {}, model {}, cache {})", facts["model name"], facts["cpu family"],
                     facts["model"], facts["cache size"]);
}

std::string system() {
  utsname name{};
  uname(&name);
  return fmt::format("{} {}", name.sysname, name.release);
}

}  // namespace

std::map<std::string, std::string> machine_facts(const std::vector<PeerEntry>& peers) {
  std::map<std::string, std::string> facts = {
      {"date", fmt::format("{:%Y-%m-%d}", fmt::localtime(std::time(nullptr)))},
      {"processor", processor()},
      {"system", system()},
      {"compiler", FOLDPROOF_BENCH_COMPILER},
      {"flags of foldproof", FOLDPROOF_BENCH_FLAGS},
      {"flags of the peers that are headers", FOLDPROOF_BENCH_PEER_FLAGS},
      {"foldproof", version()}};
  for (const PeerEntry& peer : peers) facts[peer.family] = peer.version;
  return facts;
}

bool pin_to_one_cpu(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(cpu < 0 ? sched_getcpu() : cpu, &set);
  return sched_setaffinity(0, sizeof set, &set) == 0;
}

}  // namespace foldproof::bench
