#include <fmt/format.h>

#include "base/try.h"
#include "model/balls_file.h"
#include "model/format.h"
#include "model/learned_file.h"
#include "model/limits.h"

namespace foldproof {
namespace {

using flatbuffers::FlatBufferBuilder;
template <class T>
using Structs = flatbuffers::Offset<flatbuffers::Vector<const T*>>;

std::span<const std::array<std::uint16_t, 3>> scaffold_of(const ChartLibrary& library,
                                                          const ChartLibrary::Chart& chart) {
  return library.triangles(chart).subspan(patch_triangles(*library.slots(), chart.slot, library.ring(chart)));
}

struct ChartVectors {
  Structs<file::Chart> charts;
  flatbuffers::Offset<flatbuffers::Vector<std::uint32_t>> rings;
  Structs<file::Uv> uvs;
  flatbuffers::Offset<flatbuffers::Vector<std::int16_t>> heights;
  Structs<file::ScaffoldTriangle> scaffold;
};

ChartVectors write_charts(FlatBufferBuilder& builder, const ChartLibrary& library) {
  std::vector<file::Chart> charts;
  std::vector<std::uint32_t> rings;
  std::vector<file::Uv> uvs;
  std::vector<std::int16_t> heights;
  std::vector<file::ScaffoldTriangle> scaffolds;
  for (const ChartLibrary::Chart& chart : library.charts()) {
    const auto ring = library.ring(chart);
    const auto scaffold = scaffold_of(library, chart);
    const auto points = library.points(chart).first(library.vertices(chart).size());
    charts.emplace_back(chart.slot, chart.source, static_cast<Index>(ring.size()),
                        static_cast<Index>(points.size()), static_cast<Index>(scaffold.size()));
    rings.insert(rings.end(), ring.begin(), ring.end());
    for (const auto& [x, y, height] : points) {  // integers, stored as floats
      uvs.emplace_back(static_cast<std::int16_t>(x), static_cast<std::int16_t>(y));
      heights.push_back(static_cast<std::int16_t>(height));
    }
    for (const auto& [a, b, c] : scaffold) scaffolds.emplace_back(a, b, c);
  }
  return {builder.CreateVectorOfStructs(charts), builder.CreateVector(rings),
          builder.CreateVectorOfStructs(uvs), builder.CreateVector(heights),
          builder.CreateVectorOfStructs(scaffolds)};
}

/// An upper bound on the size of the file in bytes.
std::uint64_t size_bound(const Model& model) {
  std::uint64_t bytes = 1 << 16;
  for (const ChartLibrary::Chart& chart : model.charts->charts()) {
    bytes += sizeof(file::Chart) + 4 * std::uint64_t{chart.ring.count} +
             6 * std::uint64_t{chart.vertices.count} +
             sizeof(file::ScaffoldTriangle) * scaffold_of(*model.charts, chart).size();
  }
  for (const TrainedPose& pose : model.poses) bytes += pose.name.size() + 32;
  if (model.learned) bytes += bound_of_learned_bytes(*model.learned);
  if (model.balls) bytes += bound_of_ball_bytes(*model.balls);
  return bytes + sizeof(file::HardLeaf) * model.hard_leaves.size() +
         16 * model.hierarchy()->triangles().size() + 4 * model.hierarchy()->nodes().size();
}

void build(FlatBufferBuilder& builder, const Model& model) {
  const Hierarchy& h = *model.hierarchy();
  const ChartVectors charts = write_charts(builder, *model.charts);
  std::vector<std::string> names;
  for (const TrainedPose& pose : model.poses) names.push_back(pose.name);
  const auto pose_names = builder.CreateVectorOfStrings(names);
  std::vector<file::Pose> poses;
  for (const TrainedPose& pose : model.poses) poses.emplace_back(pose.reference, pose.proven);
  std::vector<file::Triangle> triangles;
  for (const auto& [a, b, c] : h.topology().triangles()) triangles.emplace_back(a, b, c);
  std::vector<Index> leaf_sizes;
  for (const Hierarchy::Node& node : h.nodes()) {
    const Index leaf = node.leaf_begin;
    leaf_sizes.push_back(node.is_leaf() ? h.leaves()[leaf + 1].triangles - h.leaves()[leaf].triangles : 0);
  }
  std::vector<file::HardLeaf> hard;
  for (const HardLeaf& leaf : model.hard_leaves) {
    hard.emplace_back(leaf.leaf, leaf.references, static_cast<std::uint32_t>(leaf.obstacle));
  }
  const auto program = builder.CreateString(model.program);
  const auto pose_vector = builder.CreateVectorOfStructs(poses);
  const auto triangle_vector = builder.CreateVectorOfStructs(triangles);
  const auto order = builder.CreateVector(h.triangle_ids().data(), h.triangle_ids().size());
  const auto sizes = builder.CreateVector(leaf_sizes);
  const auto hard_vector = builder.CreateVectorOfStructs(hard);
  const auto learned = model.learned ? write_learned(builder, *model.learned) : 0;
  const bool keeps_balls = model.learned && model.balls;
  const auto balls = keeps_balls ? write_balls(builder, model) : 0;
  file::ModelBuilder root(builder);
  root.add_version(kModelVersion);
  root.add_program(program);
  root.add_references(model.settings.references);
  root.add_max_triangles(model.settings.max_triangles);
  root.add_pose_names(pose_names);
  root.add_poses(pose_vector);
  root.add_vertex_count(h.topology().vertex_count());
  root.add_triangles(triangle_vector);
  root.add_topology_hash(topology_hash(h.topology()));
  root.add_triangle_order(order);
  root.add_leaf_sizes(sizes);
  root.add_hard_leaves(hard_vector);
  root.add_charts(charts.charts);
  root.add_rings(charts.rings);
  root.add_uvs(charts.uvs);
  root.add_heights(charts.heights);
  root.add_scaffold(charts.scaffold);
  if (model.learned) root.add_learned(learned);
  if (keeps_balls) root.add_balls(balls);
  root.add_line_count(h.topology().line_count());
  root.add_point_count(h.topology().point_count());
  builder.FinishSizePrefixed(root.Finish(), file::ModelIdentifier());
}

}  // namespace

Result<void> save_model(const Model& model, const std::string& path) {
  FOLDPROOF_TRY(require_byte_order(path));
  auto writer = FOLDPROOF_TRY(FileWriter::open(path));
  const std::uint64_t bytes = size_bound(model);
  if (bytes >= FLATBUFFERS_MAX_BUFFER_SIZE) {
    return fail(ErrorCode::LimitExceeded, path,
                fmt::format("would have {} MB, and a model may have 2,000", bytes >> 20),
                "train with fewer references");
  }
  FlatBufferBuilder builder(bytes);
  build(builder, model);
  const auto* begin = reinterpret_cast<const char*>(builder.GetBufferPointer());
  FOLDPROOF_TRY(writer.write(std::span(begin, builder.GetSize())));
  return writer.commit();
}

}  // namespace foldproof
