// Prints: free of contact within a standard deviation: yes; on a step there: yes
// Proves how far the shapes of a learned subspace may go; steps inside need no look at the mesh.
#include "foldproof/reduced.h"

#include <cstdio>

#include "foldproof/model.h"
#include "strip.h"

int main() {
  using namespace foldproof;
  const auto motion = bending_strip(0.1, 0.8, 8);
  std::vector<TrainPose> poses;
  for (Index frame = 0; frame < motion->frame_count(); ++frame) poses.push_back({motion.get(), frame});
  const auto model = train_model(poses, {});
  if (!model) return std::puts(model.error().line().c_str()), 1;

  const auto shapes = ReducedMotion::make(model->hierarchy(), model->learned->pca);
  const std::vector<double> mean(shapes.value().modes(), 0.0);
  const auto shape = ReducedShape::build(std::make_shared<const ReducedMotion>(*shapes), {{mean}});
  if (!shape) return std::puts(shape.error().line().c_str()), 1;
  std::vector<double> p = mean;
  p[0] = 0.5 * shapes->deviations()[0];
  ReducedShape::Scratch scratch;
  std::printf("free of contact within a standard deviation: %s; on a step there: %s\n",
              shape->radius(0) > 1 ? "yes" : "no",
              shape->proven_free(mean, p, scratch) == ReducedProof::Free ? "yes" : "no");
}
