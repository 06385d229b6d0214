#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "base/try.h"
#include "commands.h"
#include "foldproof/model.h"
#include "foldproof/reduced.h"
#include "options.h"
#include "progress_bar.h"
#include "terminal.h"

namespace foldproof {
namespace {

constexpr const char* kRadiusFooter =
    R"(Within the radius of a center no combination of modes makes the surface touch itself: proven, not sampled. Distances are
in standard deviations of the training poses (Mahalanobis). The radius says nothing about regions that touch in the center's
own pose, or come closer to themselves than the clearance; these are listed. A region that nearly touches makes the radius
of the whole mesh small. With --at-least, pairs of leaves with a smaller radius are listed too, each with its own, and do
not limit the radius; larger regions still do.

Examples:
  foldproof radius body.model                        the radius around the mean, and around each cluster
  foldproof radius body.model --at-least 0.5         the radius without pairs of leaves below 0.5, which it lists
  foldproof radius body.model --save                 keep the proofs in the model, for 'radius' and 'check --reduced')";

struct RadiusArguments {
  std::string model;
  double clearance = 0, at_least = 0;
  int threads = 0;
  bool save = false, quiet = false;
  FileArguments files;
};

struct Centers {
  std::vector<std::string> names;
  std::vector<CertifiedRadius> certified;
};

Centers centers_of(const ReducedShape& shape, double at_least) {
  Centers centers;
  for (Index c = 0; c < shape.centers().size(); ++c) {
    centers.names.push_back(c == 0 ? "mean" : fmt::format("cluster {}", c - 1));
    centers.certified.push_back(shape.certified(c, at_least));
  }
  return centers;
}

std::string radius_table(const ReducedShape& shape, const Centers& centers, const Learned& learned) {
  std::string text = fmt::format("{:<12}{:>10}{:>17}{:>23}{:>29}\n", "center", "radius", "share of normal",
                                 "training poses inside", "uncertified pairs of leaves");
  const auto inside = [&](Index center, Eigen::Index pose) {
    const Eigen::VectorXd p = learned.coordinates.col(pose);
    return shape.distance(center, std::span(p.data(), static_cast<std::size_t>(p.size()))) <
           centers.certified[center].radius;
  };
  const Eigen::Index poses = learned.coordinates.cols();
  Index in_any = 0;
  for (Eigen::Index k = 0; k < poses; ++k) {
    bool any = false;
    for (Index c = 0; c < centers.names.size() && !any; ++c) any = inside(c, k);
    in_any += any;
  }
  for (Index c = 0; c < centers.names.size(); ++c) {
    Index count = 0;
    for (Eigen::Index k = 0; k < poses; ++k) count += inside(c, k);
    const auto& [radius, uncertified] = centers.certified[c];
    const auto touching = std::count_if(uncertified.begin(), uncertified.end(),
                                        [](const UncertifiedPair& pair) { return pair.touches; });
    // The normal distribution is around the mean only.
    const std::string share =
        c == 0 ? fmt::format("{:.2f} %", 100 * normal_share(radius, shape.motion()->modes())) : "";
    text += fmt::format(
        "{:<12}{:>10.4g}{:>17}{:>23}{:>29}\n", centers.names[c], radius, share,
        fmt::format("{} of {}", count, poses),
        uncertified.empty() ? "none" : fmt::format("{}, {} touch", grouped(uncertified.size()), touching));
  }
  return text + fmt::format("{} of {} training poses lie within a radius.\n", in_any, poses);
}

// Leaves that uncertified pairs connect.
struct Region {
  std::vector<Index> leaves;
  bool touches = false;
  double radius = std::numeric_limits<double>::infinity();  // within which nothing in it touches
};

std::vector<Region> regions_of(std::span<const UncertifiedPair> uncertified, Index leaf_count) {
  std::vector<Index> parent(leaf_count);
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](Index leaf) {
    while (parent[leaf] != leaf) leaf = parent[leaf] = parent[parent[leaf]];
    return leaf;
  };
  for (const UncertifiedPair& pair : uncertified) parent[root(pair.leaf_a)] = root(pair.leaf_b);
  std::map<Index, Region> regions;
  for (const UncertifiedPair& pair : uncertified) {
    Region& region = regions[root(pair.leaf_a)];
    region.touches |= pair.touches;
    region.radius = std::min(region.radius, pair.radius);
    region.leaves.insert(region.leaves.end(), {pair.leaf_a, pair.leaf_b});
  }
  std::vector<Region> sorted;
  for (auto& [_, region] : regions) {
    std::sort(region.leaves.begin(), region.leaves.end());
    region.leaves.erase(std::unique(region.leaves.begin(), region.leaves.end()), region.leaves.end());
    sorted.push_back(std::move(region));
  }
  std::stable_sort(sorted.begin(), sorted.end(), [](const Region& a, const Region& b) {
    return std::tuple(b.touches, a.radius, b.leaves.size()) <
           std::tuple(a.touches, b.radius, a.leaves.size());
  });
  return sorted;
}

std::string state(const Region& region) {
  if (region.touches) return "touches already";
  return region.radius > 0 ? fmt::format("proven up to {:.4g}", region.radius) : "closer than the clearance";
}

std::string region_list(const ReducedShape& shape, const Centers& centers) {
  constexpr std::size_t kMaxListed = 12;
  const Hierarchy& h = *shape.motion()->hierarchy();
  std::string text;
  for (Index c = 0; c < centers.names.size(); ++c) {
    const auto regions = regions_of(centers.certified[c].uncertified, h.leaf_count());
    if (regions.empty()) continue;
    std::vector<double> x(3 * std::size_t{h.topology().vertex_count()});
    shape.motion()->positions(shape.centers()[c].p, x);
    text += fmt::format("\nUncertified around {}: the radius says nothing about contact inside these {}.\n",
                        centers.names[c], counted(regions.size(), "region"));
    for (std::size_t k = 0; k < std::min(kMaxListed, regions.size()); ++k) {
      Index triangles = 0;
      for (const Index leaf : regions[k].leaves)
        triangles += h.leaves()[leaf + 1].triangles - h.leaves()[leaf].triangles;
      const Index first = h.triangle_ids()[h.leaves()[regions[k].leaves[0]].triangles];
      const Index v = h.topology().triangles()[first][0];
      text += fmt::format("  {} around triangle {} at ({:.4g}, {:.4g}, {:.4g}): {}\n",
                          counted(triangles, "triangle"), first, x[3 * v], x[3 * v + 1], x[3 * v + 2],
                          state(regions[k]));
    }
    if (regions.size() > kMaxListed)
      text += fmt::format("  and {} smaller ones\n", regions.size() - kMaxListed);
  }
  return text;
}

// Those that the model keeps, unless others are asked for.
Result<std::shared_ptr<const ReducedShape>> balls_of(const RadiusArguments& a, const Model& model,
                                                     const std::atomic<bool>& interrupted) {
  const bool fit = model.balls && (a.clearance == 0 || a.clearance == model.balls->clearance);
  if (fit && !a.save) return kept_balls(model);
  ProgressBar bar(!a.quiet);
  bar.begin("proving balls");
  ReducedHooks hooks;
  hooks.progress = [&](double part) { bar.show(part, "proving balls"); };
  hooks.cancel = &interrupted;
  return prove_balls(model, a.clearance, hooks);
}

void print_radius(const RadiusArguments& a, const Model& model, const ReducedShape& shape) {
  const Centers centers = centers_of(shape, a.at_least);
  print_output(fmt::format("{}: {}, {}; farther apart than {:.3g} mesh units\n", cell(a.model),
                           counted(shape.motion()->modes(), "mode"),
                           counted(model.hierarchy()->triangles().size(), "triangle"), shape.clearance()) +
               radius_table(shape, centers, *model.learned) + region_list(shape, centers));
}

Result<int> radius(const RadiusArguments& a) {
  std::optional<ThreadLimit> limit;
  FOLDPROOF_TRY(limit_threads(a.threads, limit));
  FOLDPROOF_TRY(require_number("--clearance", a.clearance, true));
  FOLDPROOF_TRY(require_number("--at-least", a.at_least, true));
  FOLDPROOF_TRY(a.files.check());
  auto model = FOLDPROOF_TRY(load_learned_model(a.model));
  const std::atomic<bool>& interrupted = watch_for_interrupt();
  const auto shape = balls_of(a, model, interrupted);
  if (!shape) {
    if (!interrupted) return tl::unexpected(shape.error());
    print_error({"interrupted", "while proving", "nothing was written"});
    return kExitInterrupted;
  }
  if (a.save) {
    model.balls = std::make_shared<const ReducedBalls>((*shape)->balls());
    FOLDPROOF_TRY(save_model(model, a.model));
  }
  if (!a.quiet) print_radius(a, model, **shape);
  return kExitClean;
}

}  // namespace

Command add_radius(CommandLine& program) {
  const Subcommand command =
      program.add_subcommand("radius", "Prove how far a model's shapes may go without touching themselves");
  command.footer(kRadiusFooter);
  const auto a = std::make_shared<RadiusArguments>();
  a->files.reads(command.add_option("MODEL", a->model, "A file that 'foldproof train' wrote"))
      .type_name("")
      .required();
  command
      .add_option("--clearance", a->clearance,
                  "Prove that features stay farther apart than D, in mesh units [2^-24 of the size]")
      .type_name("D");
  command
      .add_option("--at-least", a->at_least,
                  "List pairs of leaves with a smaller radius than R as uncertified, too [0]")
      .type_name("R");
  command.add_flag("--save", a->save,
                   "Prove anew, and keep the balls in MODEL, so that they need not be proven each time");
  add_threads_option(command, a->threads, "At most N threads [all cores]");
  command.add_flag("-q,--quiet", a->quiet, "Print nothing but errors");
  return [a] { return radius(*a); };
}

}  // namespace foldproof
