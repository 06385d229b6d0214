// Prints: strip.npz: 3 of 11 steps have collisions, the first in step 8
// Checks a motion from a file, step by step, with a model trained on some of its frames.
#include <cstdio>

#include "foldproof/check.h"
#include "foldproof/model.h"
#include "strip.h"

int main() {
  using namespace foldproof;
  if (!write_npz("strip.npz", *bending_strip(0.1, 8, 12))) return 1;

  const std::string path = "strip.npz";
  const auto motions = open_motions(std::span(&path, 1));
  if (!motions) return std::puts(motions.error().line().c_str()), 1;
  Motion& motion = *motions->front();
  const TrainPose poses[] = {{&motion, 0}, {&motion, 4}, {&motion, 8}};
  const auto model = train_model(poses, {});
  if (!model) return std::puts(model.error().line().c_str()), 1;

  StepChecker checker({model->object()});
  StepResult result;
  std::vector<double> x0(3 * std::size_t{motion.topology().vertex_count()}), x1(x0);
  Index colliding = 0, first = kNoIndex;
  if (const auto read = motion.read_frame(0, x0); !read) return std::puts(read.error().line().c_str()), 1;
  for (Index frame = 1; frame < motion.frame_count(); ++frame) {
    if (const auto read = motion.read_frame(frame, x1); !read)
      return std::puts(read.error().line().c_str()), 1;
    if (const auto done = checker.check(x0, x1, {}, result); !done)
      return std::puts(done.error().line().c_str()), 1;
    if (!result.clean() && colliding++ == 0) first = frame - 1;
    x0.swap(x1);
  }
  std::printf("%s: %u of %u steps have collisions, the first in step %u\n", path.c_str(), colliding,
              motion.frame_count() - 1, first);
}
