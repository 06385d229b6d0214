// Prints: strip.png has 400 x 300 pixels
// Draws a mesh into a file; no display is needed.
#include "foldproof/picture.h"

#include <cstdio>

#include "strip.h"

int main() {
  using namespace foldproof;
  const Topology topology = strip_topology();
  const std::vector<double> x = bent_strip(1.5);
  Panel panel;
  panel.meshes.push_back({.topology = &topology, .positions = x});
  panel.view = parse_view("1,-2,1").value();
  const auto image = draw_picture(std::span(&panel, 1), {.width = 400, .height = 300});
  if (!image) return std::puts(image.error().line().c_str()), 1;
  if (const auto done = write_png("strip.png", *image); !done)
    return std::puts(done.error().line().c_str()), 1;
  std::printf("strip.png has %u x %u pixels\n", image->width, image->height);
}
