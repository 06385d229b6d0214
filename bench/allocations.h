/// How often this program has asked for memory: it replaces operator new.
#pragma once

#include <cstdint>

namespace foldproof::bench {

/// Calls of operator new by all threads since the program began.
std::uint64_t allocation_count();

}  // namespace foldproof::bench
