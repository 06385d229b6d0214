/// Inside of StepChecker: what continuous and static queries share.
#pragma once

#include "query/narrow.h"
#include "query/scene.h"

namespace foldproof {

struct StepChecker::Impl {
  Scene scene;
  std::vector<Chunk> chunks;
};

}  // namespace foldproof
