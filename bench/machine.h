/// What the figures were measured on.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "competitor.h"

namespace foldproof::bench {

/// Name and value: processor, operating system, compiler, flags, versions, date.
std::map<std::string, std::string> machine_facts(const std::vector<PeerEntry>& peers);

/// Keeps this process on one processor: `cpu`, or the one it happens to run on when negative. False when
/// refused.
bool pin_to_one_cpu(int cpu);

}  // namespace foldproof::bench
