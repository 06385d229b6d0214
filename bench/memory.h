/// Peak memory of one competitor on one scene, measured in a process of its own.
#pragma once

#include <string>

#include "foldproof/bvh.h"
#include "scene.h"

namespace foldproof::bench {

struct MemoryTask {
  std::string scene;
  std::string competitor;  ///< "foldproof" or the name of a peer.
  StepSize size;
  Sampling sampling;
  HierarchySettings hierarchy;
  int threads = 1;
};

/// The largest resident size that the competitor reaches beyond what the process held before it began, in
/// bytes. Before it began: the program, the triangles and the frames of all measured steps. So what is
/// counted is everything that the competitor makes: its own copies of the input, its hierarchy, its scratch,
/// its answer, and the pages of program code that it is the first to touch.
Result<double> peak_bytes_in_child(const MemoryTask& task);

/// What the child does: runs the task and prints the bytes.
Result<void> print_peak_bytes(const MemoryTask& task);

}  // namespace foldproof::bench
