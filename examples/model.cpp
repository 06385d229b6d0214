// Prints: trained on 6 poses, of which 6 have charts; the same was read again: yes
// Trains a model on a motion, writes it and reads it again.
#include "foldproof/model.h"

#include <algorithm>
#include <cstdio>

#include "strip.h"

int main() {
  using namespace foldproof;
  const auto motion = bending_strip(0.1, 2, 6);
  std::vector<TrainPose> poses;
  for (Index frame = 0; frame < motion->frame_count(); ++frame) poses.push_back({motion.get(), frame});
  const auto model = train_model(poses, {});
  if (!model) return std::puts(model.error().line().c_str()), 1;
  if (const auto saved = save_model(*model, "example.model"); !saved)
    return std::puts(saved.error().line().c_str()), 1;
  const auto read = load_model("example.model");
  if (!read) return std::puts(read.error().line().c_str()), 1;
  std::printf("trained on %zu poses, of which %u have charts; the same was read again: %s\n",
              model->poses.size(), summarize(*model).references,
              read->chart_count() == model->chart_count() ? "yes" : "no");
}
