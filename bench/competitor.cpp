#include "competitor.h"

#include <algorithm>
#include <tuple>

namespace foldproof::bench {
namespace {

std::vector<PeerEntry>& registry() {
  static std::vector<PeerEntry> entries;
  return entries;
}

}  // namespace

std::vector<PeerEntry> peers() {
  std::vector<PeerEntry> sorted = registry();
  // Files register themselves in an order that the linker chooses: make it one that people can predict.
  std::sort(sorted.begin(), sorted.end(), [](const PeerEntry& a, const PeerEntry& b) {
    return std::tie(a.family, a.name) < std::tie(b.family, b.name);
  });
  return sorted;
}

RegisterPeer::RegisterPeer(PeerEntry entry) { registry().push_back(std::move(entry)); }

}  // namespace foldproof::bench
