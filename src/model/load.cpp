// Loads a model file: maps it, verifies its structure, then checks each part before using it.

#include <fmt/format.h>

#include <functional>

#include "base/parallel.h"
#include "base/try.h"
#include "io/bytes.h"
#include "model/balls_file.h"
#include "model/format.h"
#include "model/learned_file.h"
#include "model/limits.h"

namespace foldproof {
namespace {

/// Reads a file of verified structure and checks its contents, part by part.
class Reader {
 public:
  Reader(const file::Model& file, const std::string& path) : file_(file), path_(path) {}

  Result<Model> read() {
    Model model;
    model.name = path_;
    model.program = file_.program() ? file_.program()->str() : "";
    model.settings = {file_.references(), file_.max_triangles()};
    auto hierarchy = FOLDPROOF_TRY(read_hierarchy());
    FOLDPROOF_TRY(read_poses(model));
    FOLDPROOF_TRY(read_hard_leaves(model, hierarchy->leaf_count()));
    model.charts = FOLDPROOF_TRY(read_charts(model, hierarchy));
    if (file_.learned()) {
      model.learned =
          FOLDPROOF_TRY(read_learned(*file_.learned(), *model.hierarchy(), model.poses.size(), path_));
    }
    if (file_.balls()) model.balls = FOLDPROOF_TRY(read_balls(*file_.balls(), model, path_));
    return model;
  }

 private:
  tl::unexpected<Error> bad(const std::string& part, const std::string& problem) const {
    return fail(ErrorCode::InvalidFile, fmt::format("{}, {}", path_, part), problem, kCopyAgain);
  }

  template <class T>
  static std::size_t size(const flatbuffers::Vector<T>* vector) {
    return vector ? vector->size() : 0;
  }

  Result<Topology> read_topology() const {
    std::vector<Triangle> triangles;
    triangles.reserve(size(file_.triangles()));
    for (std::size_t k = 0; k < size(file_.triangles()); ++k) {
      const file::Triangle& t = *file_.triangles()->Get(k);
      triangles.push_back({t.a(), t.b(), t.c()});
    }
    const std::uint64_t lines = file_.line_count(), points = file_.point_count();
    if (lines + points > triangles.size()) return bad("lines and points", "are more than the triangles");
    std::vector<Edge> line_list;
    std::vector<Index> point_list;
    const std::size_t faces = triangles.size() - lines - points;
    for (std::size_t k = faces; k < triangles.size(); ++k) {
      const auto& [a, b, c] = triangles[k];
      const bool line = k < faces + lines;
      if (b != c || (!line && a != b)) return bad("lines and points", "have three vertices");
      line ? line_list.push_back({a, b}) : point_list.push_back(a);
    }
    triangles.resize(faces);
    auto topology = Topology::make(file_.vertex_count(), std::move(triangles), line_list, point_list);
    if (!topology) return bad(topology.error().where, topology.error().problem);
    return topology;
  }

  Result<std::shared_ptr<const Hierarchy>> read_hierarchy() const {
    auto topology = FOLDPROOF_TRY(read_topology());
    if (topology_hash(topology) != file_.topology_hash()) return bad("triangles", "are not those trained on");
    FOLDPROOF_TRY(require_few_loose_vertices(topology, path_));
    std::vector<Index> order, sizes;
    if (file_.triangle_order()) order.assign(file_.triangle_order()->begin(), file_.triangle_order()->end());
    if (file_.leaf_sizes()) sizes.assign(file_.leaf_sizes()->begin(), file_.leaf_sizes()->end());
    auto hierarchy = Hierarchy::from_parts(std::move(topology), std::move(order), sizes);
    if (!hierarchy) return bad(hierarchy.error().where, hierarchy.error().problem);
    FOLDPROOF_TRY(require_few_neighbors(*hierarchy, path_));
    return std::make_shared<const Hierarchy>(std::move(*hierarchy));
  }

  Result<void> read_poses(Model& model) const {
    const std::size_t count = size(file_.poses());
    if (size(file_.pose_names()) != count) return bad("poses", "are not as many as their names");
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

  /// Where the parts of a chart start in the file's arrays.
  struct Offsets {
    std::uint64_t ring = 0, uv = 0, scaffold = 0;
  };
  struct ReadChart {
    Patch patch;
    std::vector<Index> ring;
    UvMap uv_map;
    bool valid;
  };

  /// Per chart and one behind. Error: the charts do not use up the arrays exactly.
  Result<std::vector<Offsets>> find_offsets() const {
    std::vector<Offsets> offsets(1);
    for (std::size_t k = 0; k < size(file_.charts()); ++k) {
      const file::Chart& chart = *file_.charts()->Get(k);
      Offsets end = offsets.back();
      end.ring += chart.ring();
      end.uv += chart.uvs();
      end.scaffold += chart.scaffold();
      if (end.ring > size(file_.rings()) || end.uv > size(file_.uvs()) ||
          end.scaffold > size(file_.scaffold())) {
        return bad(fmt::format("chart {}", k), "has parts beyond the end of the file's arrays");
      }
      offsets.push_back(end);
    }
    const Offsets& end = offsets.back();
    if (end.ring < size(file_.rings()) || end.uv < size(file_.uvs()) ||
        end.scaffold < size(file_.scaffold()) || size(file_.heights()) != size(file_.uvs())) {
      return bad("charts", "do not use all of their parts");
    }
    return offsets;
  }

  /// Reads a chart. out.valid: it is a valid chart of its patch.
  void read_chart(const file::Chart& chart, const Offsets& start, PatchReader& reader,
                  const PatchSlots& slots, ReadChart& out) const {
    out.valid = false;
    out.ring.clear();
    for (std::size_t k = start.ring; k < start.ring + chart.ring(); ++k) {
      out.ring.push_back(file_.rings()->Get(k));
      if (out.ring.back() >= slots.hierarchy()->leaf_count()) return;
    }
    // Reads the patch only if its size fits, as a file may name a large patch a million times. A square with
    // n vertices inside has 2 n + 2 triangles.
    const std::uint64_t triangles = patch_triangles(slots, chart.slot(), out.ring);
    if (triangles + chart.scaffold() != 2 * std::uint64_t{chart.uvs()} + 2) return;
    out.uv_map = {};
    for (std::size_t k = start.uv; k < start.uv + chart.uvs(); ++k) {
      out.uv_map.uvs.push_back({file_.uvs()->Get(k)->x(), file_.uvs()->Get(k)->y()});
      out.uv_map.heights.push_back(file_.heights()->Get(k));
    }
    for (std::size_t k = start.scaffold; k < start.scaffold + chart.scaffold(); ++k) {
      const file::ScaffoldTriangle& t = *file_.scaffold()->Get(k);
      out.uv_map.scaffold.push_back({t.a(), t.b(), t.c()});
    }
    reader.read(chart.slot(), out.patch);
    for (const Index leaf : out.ring) reader.add_leaf(leaf, out.patch);
    out.valid = chart_is_valid(out.patch, out.uv_map);
  }

  Result<std::shared_ptr<const ChartLibrary>> read_charts(const Model& model,
                                                          std::shared_ptr<const Hierarchy> hierarchy) const {
    const auto offsets = FOLDPROOF_TRY(find_offsets());
    const auto slots = std::make_shared<const PatchSlots>(std::move(hierarchy));
    const auto library = std::make_shared<ChartLibrary>(slots);
    PerThread<PatchReader> readers([&] { return PatchReader(*slots); });
    std::vector<ReadChart> batch(1024);
    for (std::size_t first = 0; first < size(file_.charts()); first += batch.size()) {
      const std::size_t count = std::min(batch.size(), size(file_.charts()) - first);
      for (std::size_t k = first; k < first + count; ++k) {
        const file::Chart& chart = *file_.charts()->Get(k);
        const bool known = chart.pose() < model.poses.size() && model.poses[chart.pose()].reference;
        if (chart.slot() >= slots->count()) return bad(fmt::format("chart {}", k), "belongs to no patch");
        if (!known) return bad(fmt::format("chart {}", k), "comes from no reference pose");
      }
      parallel_for(std::size_t{0}, count, [&](std::size_t k) {
        read_chart(*file_.charts()->Get(first + k), offsets[first + k], readers.local(), *slots, batch[k]);
      });
      for (std::size_t k = 0; k < count; ++k) {
        const file::Chart& chart = *file_.charts()->Get(first + k);
        if (!batch[k].valid)
          return bad(fmt::format("chart {}", first + k), "is not a valid chart of its patch");
        library->add(chart.slot(), chart.pose(), batch[k].patch, batch[k].ring, batch[k].uv_map);
      }
    }
    return library;
  }

  const file::Model& file_;
  const std::string& path_;
};

/// Whether the bytes are a FlatBuffer of type T.
template <class T>
bool has_structure(std::span<const std::uint8_t> bytes) {
  flatbuffers::Verifier verifier(bytes.data(), bytes.size());
  return verifier.VerifySizePrefixedBuffer<T>(file::ModelIdentifier());
}

}  // namespace

Result<Model> load_model(const std::string& path) {
  FOLDPROOF_TRY(require_byte_order(path));
  const std::vector<char> file = FOLDPROOF_TRY(io::read_file(path));
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(file.data()), file.size());
  constexpr std::size_t kIdentifierEnd = 12;  // size, offset of the root, identifier
  if (bytes.size() < kIdentifierEnd || bytes.size() >= FLATBUFFERS_MAX_BUFFER_SIZE ||
      !file::SizePrefixedModelBufferHasIdentifier(bytes.data())) {
    return fail(ErrorCode::UnsupportedFormat, path, "is not a Foldproof model",
                "make one with 'foldproof train'");
  }
  const auto damaged = fail(ErrorCode::InvalidFile, path, "is damaged or cut off", kCopyAgain);
  if (!has_structure<file::Header>(bytes)) return damaged;
  const auto version = flatbuffers::GetSizePrefixedRoot<file::Header>(bytes.data())->version();
  if (version < kOldestModelVersion || version > kModelVersion) {
    return fail(ErrorCode::UnsupportedFormat, path,
                fmt::format("has format version {}, and this program reads {} to {}", version,
                            kOldestModelVersion, kModelVersion),
                "use the version of Foldproof that wrote it, or train it again");
  }
  if (!has_structure<file::Model>(bytes)) return damaged;
  return Reader(*file::GetSizePrefixedModel(bytes.data()), path).read();
}

}  // namespace foldproof
