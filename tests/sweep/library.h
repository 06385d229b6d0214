/// Libraries of motions to sweep.
#pragma once

#include "report/sinking_triangle.h"
#include "sweep/sweep.h"

namespace foldproof::testing {

/// Motions as NPZ files and the sweep of them.
struct Library : TemporaryDirectory {
  void add(const std::string& name, const std::vector<double>& heights) const {
    const auto written = write_npz(*this / ("in/" + name), *sinking_triangle(heights));
    ASSERT_TRUE(written) << written.error().line();
  }
  Library() { std::filesystem::create_directory(*this / "in"); }

  SweepInput input() const {
    const std::string directories[] = {*this / "in"};
    return find_motions(directories).value();
  }
  std::string results() const { return *this / "results.jsonl"; }

  Result<SweepFile> open(const SweepInput& found, bool again = false) const {
    return SweepFile::open(results(), found, settings_hash(settings), again);
  }

  /// Checks the remaining motions; returns their indices.
  std::vector<std::size_t> sweep(bool again = false) const {
    const SweepInput found = input();
    auto file = open(found, again);
    EXPECT_TRUE(file) << file.error().line();
    if (!file) return {};
    const std::vector<std::size_t> remaining = file->remaining();
    for (const std::size_t motion : remaining) {
      const auto line = sweep_line(found.motions[motion], settings);
      EXPECT_TRUE(line && file->add(*line));
    }
    EXPECT_EQ(file->records().size(), found.motions.size());
    return remaining;
  }

  SweepSettings settings;
};

struct ThreeNeedles : Library {
  ThreeNeedles() {
    add("a.npz", kSinking);
    add("b.npz", {3, 2, 1});
    add("c.npz", {1});
  }
};

inline SweepRecord record_of(const std::string& line) {
  const auto record = read_sweep_line(line);
  EXPECT_TRUE(record) << line;
  return record.value_or(SweepRecord{});
}

}  // namespace foldproof::testing
