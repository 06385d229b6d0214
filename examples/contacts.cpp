// Prints: contact 1: first at time 1.80, worst at time 3, 1.20 deep; its point is (0.50, 0.50, -1.20)
// Checks a motion frame by frame and prints what goes through what, when, and how deep.
#include "foldproof/contacts.h"

#include <cstdio>

int main() {
  using namespace foldproof;
  // A tetrahedron sinks through a floor, one unit each frame.
  const auto mesh = Topology::make(7, {{0, 1, 2}, {3, 5, 4}, {3, 4, 6}, {4, 5, 6}, {5, 3, 6}}).value();
  std::vector<double> x;
  const auto set_pose = [&](int frame) {
    const double z = 1.8 - frame;
    x = {-9, -9, 0, 20, -9, 0, -9, 20, 0, 0, 0, z + 2, 1.5, 0, z + 2, 0, 1.5, z + 2, 0.5, 0.5, z};
  };
  set_pose(0);
  const std::vector<Object> objects{Hierarchy::build(mesh, x).value()};
  int frame = 0;
  const auto next = [&]() -> Result<std::optional<MotionFrame>> {
    if (frame > 3) return std::nullopt;
    set_pose(frame);
    return MotionFrame{static_cast<double>(frame++), x};
  };
  const auto done = find_contacts(objects, next, [](const Contact& contact) {
    std::printf("contact %u: first at time %.2f", contact.number, contact.first_time);
    if (const auto depth = contact.depth())
      std::printf(", worst at time %g, %.2f deep", contact.frames[contact.worst].time, *depth);
    std::printf("; its point is (%.2f, %.2f, %.2f)\n", contact.point[0], contact.point[1], contact.point[2]);
  });
  return done ? 0 : 1;
}
