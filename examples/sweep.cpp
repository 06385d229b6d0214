// Prints: strip.npz collides: 3 of 11 steps
// Checks all motions below a directory, and those that have a line already only once.
#include "foldproof/sweep.h"

#include <cstdio>
#include <filesystem>

#include "strip.h"

int main() {
  using namespace foldproof;
  std::filesystem::create_directory("library");
  const auto strip = bending_strip(0.1, 8, 12);
  if (!write_npz("library/strip.npz", *strip)) return 1;

  const std::string directories[] = {"library"};
  const SweepSettings settings;
  const auto input = find_motions(directories);
  if (!input) return std::puts(input.error().line().c_str()), 1;
  auto file = SweepFile::open("strips.jsonl", *input, settings_hash(settings), false);
  if (!file) return std::puts(file.error().line().c_str()), 1;
  for (const std::size_t motion : file->left()) {
    const auto line = sweep_line(input->motions[motion], settings);
    if (const auto done = file->add(*line); !done) return std::puts(done.error().line().c_str()), 1;
  }
  for (const SweepRecord& r : file->records()) {
    std::printf("%s %s: %lu of %lu steps\n", std::filesystem::path(r.path).filename().c_str(),
                name_of(r.state), r.steps_with_collisions, r.steps);
  }
}
