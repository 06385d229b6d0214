// A model file is mapped, verified, and then checked part by part before anything in it is believed.

#include <fmt/format.h>

#include <functional>

#include "base/parallel.h"
#include "io/bytes.h"
#include "model/format.h"
#include "model/learned_file.h"
#include "model/limits.h"

namespace foldproof {
namespace {

/// A file whose structure has been verified; its contents are checked here, part by part.
class Reader {
 public:
  Reader(const file::Model& file, const std::string& path) : file_(file), path_(path) {}

  Result<Model> read() {
    Model model;
    model.name = path_;
    model.program = file_.program() ? file_.program()->str() : "";
    model.settings = {file_.references(), file_.most_triangles()};
    auto hierarchy = read_hierarchy();
    if (!hierarchy) return tl::unexpected(hierarchy.error());
    if (auto ok = read_poses(model); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_hard_leaves(model, (*hierarchy)->leaf_count()); !ok) return tl::unexpected(ok.error());
    auto charts = read_charts(model, *hierarchy);
    if (!charts) return tl::unexpected(charts.error());
    model.charts = std::move(*charts);
    if (file_.learned()) {
      auto learned = read_learned(*file_.learned(), *model.hierarchy(), model.poses.size(), path_);
      if (!learned) return tl::unexpected(learned.error());
      model.learned = std::move(*learned);
    }
    return model;
  }

 private:
  tl::unexpected<Error> bad(const std::string& place, const std::string& problem) const {
    return fail(fmt::format("{}, {}", path_, place), problem, kCopyAgain);
  }

  template <class T>
  static std::size_t size(const flatbuffers::Vector<T>* vector) {
    return vector ? vector->size() : 0;
  }

  Result<std::shared_ptr<const Hierarchy>> read_hierarchy() const {
    std::vector<Triangle> triangles;
    triangles.reserve(size(file_.triangles()));
    for (std::size_t k = 0; k < size(file_.triangles()); ++k) {
      const file::Triangle& t = *file_.triangles()->Get(k);
      triangles.push_back({t.a(), t.b(), t.c()});
    }
    auto topology = Topology::make(file_.vertex_count(), std::move(triangles));
    if (!topology) return bad(topology.error().where, topology.error().problem);
    if (topology_hash(*topology) != file_.topology_hash())
      return bad("triangles", "are not those trained on");
    if (auto ok = require_few_loose_vertices(*topology, path_); !ok) return tl::unexpected(ok.error());
    std::vector<Index> order, sizes;
    if (file_.triangle_order()) order.assign(file_.triangle_order()->begin(), file_.triangle_order()->end());
    if (file_.leaf_sizes()) sizes.assign(file_.leaf_sizes()->begin(), file_.leaf_sizes()->end());
    auto hierarchy = Hierarchy::from_parts(std::move(*topology), std::move(order), sizes);
    if (!hierarchy) return bad(hierarchy.error().where, hierarchy.error().problem);
    if (auto ok = require_few_neighbours(*hierarchy, path_); !ok) return tl::unexpected(ok.error());
    return std::make_shared<const Hierarchy>(std::move(*hierarchy));
  }

  Result<void> read_poses(Model& model) const {
    const std::size_t count = size(file_.poses());
    if (size(file_.pose_names()) != count) return bad("poses", "have other names than they are many");
    for (std::size_t k = 0; k < count; ++k) {
      const file::Pose& pose = *file_.poses()->Get(k);
      if (!(pose.proven() >= 0 && pose.proven() <= 1)) {
        return bad(fmt::format("pose {}", k), "has a share that is not between 0 and 1");
      }
      model.poses.push_back({file_.pose_names()->Get(k)->str(), pose.reference(), pose.proven()});
    }
    return {};
  }

  Result<void> read_hard_leaves(Model& model, Index leaf_count) const {
    for (std::size_t k = 0; k < size(file_.hard_leaves()); ++k) {
      const file::HardLeaf& hard = *file_.hard_leaves()->Get(k);
      const bool ascending = k == 0 || hard.leaf() > model.hard_leaves.back().leaf;
      if (hard.leaf() >= leaf_count || !ascending || hard.references() < 1 ||
          hard.references() > model.poses.size() ||
          hard.obstacle() > static_cast<std::uint32_t>(Obstacle::TooThin)) {
        return bad(fmt::format("hard leaf {}", k), "makes no sense");
      }
      model.hard_leaves.push_back({hard.leaf(), hard.references(), static_cast<Obstacle>(hard.obstacle())});
    }
    return {};
  }

  /// Where the parts of a chart begin.
  struct Begin {
    std::uint64_t collar = 0, place = 0, filler = 0;
  };
  /// A chart on its way into the library.
  struct Arrival {
    Patch patch;
    std::vector<Index> collar;
    Drawing drawing;
    bool valid;
  };

  /// Error when the charts do not use up exactly what there is of their parts.
  Result<std::vector<Begin>> find_parts() const {
    std::vector<Begin> begins(1);
    for (std::size_t k = 0; k < size(file_.charts()); ++k) {
      const file::Chart& chart = *file_.charts()->Get(k);
      Begin end = begins.back();
      end.collar += chart.collar();
      end.place += chart.places();
      end.filler += chart.fillers();
      if (end.collar > size(file_.collars()) || end.place > size(file_.places()) ||
          end.filler > size(file_.fillers())) {
        return bad(fmt::format("chart {}", k), "is not all there");
      }
      begins.push_back(end);
    }
    const Begin& end = begins.back();
    if (end.collar < size(file_.collars()) || end.place < size(file_.places()) ||
        end.filler < size(file_.fillers()) || size(file_.heights()) != size(file_.places())) {
      return bad("charts", "are fewer than what is drawn");
    }
    return begins;
  }

  /// Reads a chart; out.valid tells whether it is a proper drawing of its patch.
  void take(const file::Chart& chart, const Begin& begin, PatchReader& reader, const PatchSlots& slots,
            Arrival& out) const {
    out.valid = false;
    out.collar.clear();
    for (std::size_t k = begin.collar; k < begin.collar + chart.collar(); ++k) {
      out.collar.push_back(file_.collars()->Get(k));
      if (out.collar.back() >= slots.hierarchy()->leaf_count()) return;
    }
    // Only what can fit the drawing is read: a file may name a large patch a million times. The square with n
    // vertices inside has 2 n + 2 triangles.
    const std::uint64_t triangles = patch_triangles(slots, chart.slot(), out.collar);
    if (triangles + chart.fillers() != 2 * std::uint64_t{chart.places()} + 2) return;
    out.drawing = {};
    for (std::size_t k = begin.place; k < begin.place + chart.places(); ++k) {
      out.drawing.places.push_back({file_.places()->Get(k)->x(), file_.places()->Get(k)->y()});
      out.drawing.heights.push_back(file_.heights()->Get(k));
    }
    for (std::size_t k = begin.filler; k < begin.filler + chart.fillers(); ++k) {
      const file::Filler& f = *file_.fillers()->Get(k);
      out.drawing.fillers.push_back({f.a(), f.b(), f.c()});
    }
    reader.read(chart.slot(), out.patch);
    for (const Index leaf : out.collar) reader.add_leaf(leaf, out.patch);
    out.valid = chart_is_valid(out.patch, out.drawing);
  }

  Result<std::shared_ptr<const ChartLibrary>> read_charts(const Model& model,
                                                          std::shared_ptr<const Hierarchy> hierarchy) const {
    const auto begins = find_parts();
    if (!begins) return tl::unexpected(begins.error());
    const auto slots = std::make_shared<const PatchSlots>(std::move(hierarchy));
    const auto library = std::make_shared<ChartLibrary>(slots);
    PerThread<PatchReader> readers([&] { return PatchReader(*slots); });
    std::vector<Arrival> arrivals(1024);
    for (std::size_t first = 0; first < size(file_.charts()); first += arrivals.size()) {
      const std::size_t count = std::min(arrivals.size(), size(file_.charts()) - first);
      for (std::size_t k = first; k < first + count; ++k) {
        const file::Chart& chart = *file_.charts()->Get(k);
        const bool known = chart.pose() < model.poses.size() && model.poses[chart.pose()].reference;
        if (chart.slot() >= slots->count()) return bad(fmt::format("chart {}", k), "belongs to no patch");
        if (!known) return bad(fmt::format("chart {}", k), "comes from no reference pose");
      }
      parallel_for(std::size_t{0}, count, [&](std::size_t k) {
        take(*file_.charts()->Get(first + k), (*begins)[first + k], readers.local(), *slots, arrivals[k]);
      });
      for (std::size_t k = 0; k < count; ++k) {
        const file::Chart& chart = *file_.charts()->Get(first + k);
        if (!arrivals[k].valid) return bad(fmt::format("chart {}", first + k), "is no drawing of its patch");
        library->add(chart.slot(), chart.pose(), arrivals[k].patch, arrivals[k].collar, arrivals[k].drawing);
      }
    }
    return library;
  }

  const file::Model& file_;
  const std::string& path_;
};

/// Whether the bytes have the structure of a T.
template <class T>
bool has_structure(std::span<const std::uint8_t> bytes) {
  flatbuffers::Verifier verifier(bytes.data(), bytes.size());
  return verifier.VerifySizePrefixedBuffer<T>(file::ModelIdentifier());
}

}  // namespace

Result<Model> load_model(const std::string& path) {
  const auto mapped = io::MappedFile::open(path);
  if (!mapped) return tl::unexpected(mapped.error());
  const auto bytes = mapped->bytes();
  constexpr std::size_t kIdentifierEnd = 12;  // behind the size and the offset of the root
  if (bytes.size() < kIdentifierEnd || bytes.size() >= FLATBUFFERS_MAX_BUFFER_SIZE ||
      !file::SizePrefixedModelBufferHasIdentifier(bytes.data())) {
    return fail(path, "is not a Foldproof model", "make one with 'foldproof train'");
  }
  const auto damaged = fail(path, "is damaged or cut off", kCopyAgain);
  if (!has_structure<file::Header>(bytes)) return damaged;
  const auto version = flatbuffers::GetSizePrefixedRoot<file::Header>(bytes.data())->version();
  if (version < kOldestModelVersion || version > kModelVersion) {
    return fail(path,
                fmt::format("has format version {}, and this program reads {} to {}", version,
                            kOldestModelVersion, kModelVersion),
                "use the version of Foldproof that wrote it, or train it anew");
  }
  if (!has_structure<file::Model>(bytes)) return damaged;
  return Reader(*file::GetSizePrefixedModel(bytes.data()), path).read();
}

}  // namespace foldproof
