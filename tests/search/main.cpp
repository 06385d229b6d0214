// Tries to break certificates: moves vertices towards collisions while charts and planes keep saying that
// there are none, and asks exact arithmetic. Finding one is a failure.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "bvh/kinetic_bvh.h"
#include "certificate/chart_builder.h"
#include "search/arena.h"
#include "search/meshes.h"

namespace foldproof::search {
namespace {

struct Options {
  double seconds = 5;
  std::uint64_t seed = 1;
  std::string mesh;          // all of them when empty
  std::uint64_t attack = 0;  // the first
  bool single = false;       // only that one
  bool real = true;
  Honesty honesty = Honesty::Real;
};

// A mesh with what is needed to build charts of its patches.
class Target {
 public:
  Target(SearchMesh mesh, Honesty honesty) : mesh_(std::move(mesh)), honesty_(honesty) {
    hierarchy_ = std::make_shared<const Hierarchy>(Hierarchy::build(mesh_.topology, mesh_.positions).value());
    slots_ = std::make_unique<PatchSlots>(hierarchy_);
    builder_ = std::make_unique<ChartBuilder>(*slots_);
    reader_ = std::make_unique<PatchReader>(*slots_);
    tree_ = std::make_unique<KineticBvh>(hierarchy_);
    low_ = high_ = Vec3(mesh_.positions[0], mesh_.positions[1], mesh_.positions[2]);
    for (std::size_t i = 0; i < mesh_.positions.size(); i += 3) {
      const Vec3 p(mesh_.positions[i], mesh_.positions[i + 1], mesh_.positions[i + 2]);
      low_ = low_.cwiseMin(p);
      high_ = high_.cwiseMax(p);
    }
  }

  const std::string& name() const { return mesh_.name; }
  Tally tally;

  /// One attack, decided by the mesh, the seed and its number alone. A complaint, or nothing.
  std::string attack(std::uint64_t seed, std::uint64_t number) {
    Rng rng(seed * 0x9E3779B97F4A7C15u + number);
    return number % 4 == 3 ? attack_plane(rng) : attack_chart(rng);
  }

 private:
  static constexpr int kTries = 6000;
  static constexpr Index kMaxLeaves = 8;

  // Around the mesh with a little room, or around a scene in which the mesh is small and off the center,
  // anywhere.
  Frame frame(Rng& rng) const {
    const double size = (high_ - low_).maxCoeff();
    const double room = size * (rng() % 2 ? 0.3 : testing::log_uniform(rng, 0.3, 1e4));
    const Vec3 off = room * 0.9 * Vec3(testing::uniform(rng, -1, 1), testing::uniform(rng, -1, 1), 1);
    return frame_around(low_ - Vec3::Constant(room) + off, high_ + Vec3::Constant(room) + off);
  }

  std::vector<Vec3> pose(std::span<const Index> vertices) const {
    std::vector<Vec3> x;
    for (const Index v : vertices) {
      const double* p = &mesh_.positions[3 * std::size_t{hierarchy_->vertex_ids()[v]}];
      x.emplace_back(p[0], p[1], p[2]);
    }
    return x;
  }

  Ground ground(const Frame& frame, Rng& rng) const {
    const double edge = (high_ - low_).maxCoeff() / std::sqrt(double(hierarchy_->vertex_ids().size()));
    return {frame, rng() % 3 == 0 ? edge * testing::log_uniform(rng, 1e-5, 0.3) : 0};
  }

  std::string attack_chart(Rng& rng) {
    const Ground where = ground(frame(rng), rng);
    tree_->refit(where.frame, mesh_.positions, mesh_.positions);
    for (int search = 0; search < 200; ++search) {
      const auto slot = static_cast<Index>(rng() % slots_->count());
      if (too_large(slot)) continue;
      built_.slot = slot;
      builder_->build(tree_->vertices, built_);
      if (built_.outcome != ChartOutcome::Made) continue;
      const auto certificate = chart_certificate(built_.patch, built_.uv_map, honesty_);
      if (certificate->pairs().empty()) continue;
      return Attack(*certificate, where, pose(built_.patch.vertices), rng).run(kTries, tally);
    }
    return {};
  }

  std::string attack_plane(Rng& rng) {
    const Ground where = ground(frame(rng), rng);
    for (int search = 0; search < 200; ++search) {
      const auto a = static_cast<Index>(rng() % hierarchy_->leaf_count());
      // Near by in leaf order is mostly near by in space.
      const Index b = static_cast<Index>((a + 1 + rng() % 12) % hierarchy_->leaf_count());
      if (a == b || slots_->of_leaves(a, b) != kNoIndex) continue;
      const Patch patch_a = leaf(a), patch_b = leaf(b);
      std::vector<Index> vertices = patch_a.vertices;
      vertices.insert(vertices.end(), patch_b.vertices.begin(), patch_b.vertices.end());
      const auto certificate = plane_certificate(patch_a, patch_b, honesty_);
      return Attack(*certificate, where, pose(vertices), rng).run(kTries, tally);
    }
    return {};
  }

  // Leaves hold a dozen triangles or so.
  bool too_large(Index slot) const {
    if (slots_->is_pair(slot)) return false;
    const Hierarchy::Node& node = hierarchy_->nodes()[slot];
    return node.leaf_end - node.leaf_begin > kMaxLeaves;
  }

  Patch leaf(Index number) {
    for (Index node = 0; node < hierarchy_->nodes().size(); ++node) {
      const Hierarchy::Node& n = hierarchy_->nodes()[node];
      if (!n.is_leaf() || n.leaf_begin != number) continue;
      Patch patch;
      reader_->read(slots_->of_node(node), patch);
      return patch;
    }
    return {};
  }

  SearchMesh mesh_;
  Honesty honesty_;
  std::shared_ptr<const Hierarchy> hierarchy_;
  std::unique_ptr<PatchSlots> slots_;
  std::unique_ptr<ChartBuilder> builder_;
  std::unique_ptr<PatchReader> reader_;
  std::unique_ptr<KineticBvh> tree_;
  BuiltChart built_;
  Vec3 low_, high_;
};

bool report_failure(const Target& target, const Options& options, std::uint64_t number,
                    const std::string& complaint) {
  fmt::print("FAILED {} attack {} of seed {}\n{}\nAgain: search --mesh {} --seed {} --attack {}\n",
             target.name(), number, options.seed, complaint, target.name(), options.seed, number);
  return false;
}

// Meshes take turns, an attack each, until the time is over.
bool run(std::vector<Target>& targets, const Options& options) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(options.seconds));
  bool clean = true;
  for (std::uint64_t number = options.attack; clean; ++number) {
    for (Target& target : targets) {
      const std::string complaint = target.attack(options.seed, number);
      if (!complaint.empty()) clean = report_failure(target, options, number, complaint);
    }
    if (options.single || Clock::now() >= end) break;
  }
  return clean;
}

void print_row(const std::string& name, const Tally& t) {
  fmt::print("{:24} {:8} {:12} {:12} {:10} {:10.4g}\n", name, t.attacks, t.tries, t.accepted, t.asked,
             t.least_ratio);
}

int usage() {
  fmt::print(
      "usage: search [--seconds S] [--seed N] [--mesh NAME] [--attack K] [--generated]\n\n"
      "Attacks certificates for S seconds (5) in all. --attack K makes one attack only, as it was made "
      "before with\n"
      "the same mesh and seed. --generated leaves real meshes out. --planted\n"
      "attacks certificates with a mistake in them, to see that it is found.\n");
  return 2;
}

bool parse(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--generated" || name == "--planted") {
      if (name == "--generated") options.real = false;
      if (name == "--planted") options.honesty = Honesty::Planted;
      continue;
    }
    if (++i == argc) return false;
    if (name == "--seconds") {
      options.seconds = std::strtod(argv[i], nullptr);
    } else if (name == "--seed") {
      options.seed = std::strtoull(argv[i], nullptr, 10);
    } else if (name == "--mesh") {
      options.mesh = argv[i];
    } else if (name == "--attack") {
      options.attack = std::strtoull(argv[i], nullptr, 10);
      options.single = true;
    } else {
      return false;
    }
  }
  return true;
}

int main_of_search(int argc, char** argv) {
  Options options;
  if (!parse(argc, argv, options)) return usage();
  std::vector<SearchMesh> meshes = generated_meshes();
  if (options.real) {
    for (SearchMesh& mesh : real_meshes()) meshes.push_back(std::move(mesh));
  }
  std::vector<Target> targets;
  for (SearchMesh& mesh : meshes) {
    if (options.mesh.empty() || mesh.name == options.mesh)
      targets.emplace_back(std::move(mesh), options.honesty);
  }
  if (targets.empty()) return usage();
  const bool clean = run(targets, options);
  fmt::print("{:24} {:>8} {:>12} {:>12} {:>10} {:>10}\n", "mesh", "attacks", "moves tried", "accepted",
             "asked exactly", "nearest / promised");
  Tally all;
  for (const Target& target : targets) {
    print_row(target.name(), target.tally);
    all.add(target.tally);
  }
  fmt::print("{} attacks, {} of {} moves accepted, {} pairs asked exactly; nearest / promised {:.4g}\n",
             all.attacks, all.accepted, all.tries, all.asked, all.least_ratio);
  // An attack that never gets anywhere shows nothing.
  if (clean && all.accepted == 0) fmt::print("FAILED: no move was accepted\n");
  return clean && all.accepted > 0 ? 0 : 1;
}

}  // namespace
}  // namespace foldproof::search

int main(int argc, char** argv) { return foldproof::search::main_of_search(argc, argv); }
