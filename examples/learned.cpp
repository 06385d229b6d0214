// Prints: 10 key points of 123 vertices tell a pose nobody trained, to less than a percent: yes
// Rebuilds a whole pose from where its key points are.
#include "foldproof/learned.h"

#include <cstdio>

#include "foldproof/model.h"
#include "strip.h"

int main() {
  using namespace foldproof;
  const auto motion = bending_strip(0.1, 2, 12);
  std::vector<TrainPose> poses;
  for (Index frame = 0; frame < motion->frame_count(); ++frame) poses.push_back({motion.get(), frame});
  TrainSettings settings;
  settings.learning.key_points = {.first_share = 0.05, .max_share = 0.085};
  const auto model = train_model(poses, settings);
  if (!model) return std::puts(model.error().line().c_str()), 1;

  const std::vector<double> unseen = bent_strip(1.234);
  const Eigen::Map<const Eigen::VectorXd> x(unseen.data(), static_cast<Eigen::Index>(unseen.size()));
  const Predictor predictor(model->learned);
  const Eigen::VectorXd rebuilt = predictor.from_key_points(predictor.key_point_map().gather(x));
  std::printf("%zu key points of %td vertices tell a pose nobody trained, to less than a percent: %s\n",
              model->learned->key_points.vertices.size(), x.size() / 3,
              vertex_distance(x, rebuilt).worst < 0.01 * model->learned->size ? "yes" : "no");
}
