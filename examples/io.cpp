// Prints: io_example.npz: 2 frames of 3 vertices, the last at height 2
// Writes a motion and reads it again, frame by frame.
#include <cstdio>

#include "foldproof/io.h"

int main() {
  using namespace foldproof;
  const auto triangle = Topology::make(3, {{0, 1, 2}});
  const auto rising =
      memory_motion("rising", triangle.value(), {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 2, 1, 0, 2, 0, 1, 2}});
  const std::string path = "io_example.npz";
  if (const auto done = write_npz(path, *rising); !done) return std::puts(done.error().line().c_str()), 1;

  const auto motions = open_motions(std::span(&path, 1));
  if (!motions) return std::puts(motions.error().line().c_str()), 1;
  Motion& motion = *motions->front();
  std::vector<double> x(std::size_t{motion.topology().vertex_count()} * 3);
  if (const auto read = motion.read_frame(1, x); !read) return std::puts(read.error().line().c_str()), 1;
  std::printf("%s: %u frames of %u vertices, the last at height %g\n", motion.name().c_str(),
              motion.frame_count(), motion.topology().vertex_count(), x[2]);
}
