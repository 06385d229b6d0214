#include "certificates.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "base/try.h"
#include "foldproof/model.h"
#include "measure.h"
#include "subdivide.h"
#include "verify.h"

namespace foldproof::bench {
namespace {

using nlohmann::json;

enum class Training { None, EveryTenthFrame, OwnPoses };

const char* name_of(Training training) {
  switch (training) {
    case Training::None:
      return "none";
    case Training::EveryTenthFrame:
      return "every 10th frame";
    case Training::OwnPoses:
      return "separate poses";
  }
  return "";
}

// Poses of the same mesh that are not of the motion; the lion's are of the mesh that lion-anim was subdivided
// from.
std::vector<std::string> separate_poses(const std::string& scene) {
  static const std::map<std::string, std::vector<std::string>> files = {
      {"elephant-gallop", {"elephant/elephant-poses.obj", "elephant/elephant-poses.pc2"}},
      {"horse-gallop", {"horse-poses/pose_*.obj"}},
      {"lion-anim", {"lion-poses/pose_*.obj"}},
      {"hand-anim", {"hand/hand-poses.obj", "hand/hand-poses.pc2"}}};
  const auto found = files.find(scene);
  return found == files.end() ? std::vector<std::string>{} : found->second;
}

struct Row {
  std::string scene;
  StepSize size = StepSize::Full;
  Training training = Training::None;
  Index references = 0, steps = 0;
  double train_seconds = 0, model_bytes = 0;
  double on = 0, off = 0;  // milliseconds, of all steps together, as what follows
  double pairs_on = 0, pairs_off = 0, colliding = 0, tests = 0;
};

// Which leaf owns each feature, to tell pairs of leaves that truly collide from the others.
class LeafOwners {
 public:
  explicit LeafOwners(const Hierarchy& h)
      : vertex_(h.topology().vertex_count()), face_(h.topology().triangles().size()) {
    for (Index leaf = 0; leaf < h.leaf_count(); ++leaf) {
      const auto &begin = h.leaves()[leaf], &end = h.leaves()[leaf + 1];
      for (Index i = begin.vertices; i < end.vertices; ++i) vertex_[h.vertex_ids()[i]] = leaf;
      for (Index i = begin.triangles; i < end.triangles; ++i) face_[h.triangle_ids()[i]] = leaf;
      for (Index i = begin.edges; i < end.edges; ++i) edge_[h.topology().edges()[h.edge_ids()[i]]] = leaf;
    }
  }
  double colliding_pairs(const StepResult& result) const {
    std::set<std::pair<Index, Index>> pairs;
    for (const auto& c : result.vertex_face) pairs.insert(std::minmax(vertex_[c.vertex], face_[c.face]));
    for (const auto& c : result.edge_edge) pairs.insert(std::minmax(edge_.at(c.a), edge_.at(c.b)));
    return static_cast<double>(pairs.size());
  }

 private:
  std::vector<Index> vertex_, face_;
  std::map<Edge, Index> edge_;
};

// Trains as a user would: on every tenth frame of the motion itself, or on other poses of the mesh.
Result<std::shared_ptr<const ChartLibrary>> trained(const SceneInfo& scene, Motion& motion,
                                                    const CertificatePlan& plan, Row& row) {
  std::shared_ptr<const ChartLibrary> none;
  if (row.training == Training::None) return none;
  std::vector<std::unique_ptr<Motion>> others;
  std::vector<TrainPose> poses;
  if (row.training == Training::EveryTenthFrame) {
    for (Index frame = 0; frame < motion.frame_count(); frame += 10) poses.push_back({&motion, frame});
  } else {
    std::vector<std::string> files;
    for (const std::string& file : separate_poses(scene.name))
      files.push_back((data_directory() / file).string());
    auto opened = FOLDPROOF_TRY(open_motions(files));
    others = std::move(opened);
    for (auto& other : others) {
      if (other->topology().vertex_count() < motion.topology().vertex_count()) {
        auto fine = FOLDPROOF_TRY(subdivide_like(motion.topology(), *other));
        other = std::move(fine);
      }
      for (Index frame = 0; frame < other->frame_count(); ++frame) poses.push_back({other.get(), frame});
    }
  }
  const double start = now_milliseconds(plan.processor_time);
  auto model = FOLDPROOF_TRY(train_model(poses, {}));
  row.train_seconds = (now_milliseconds(plan.processor_time) - start) / 1e3;
  row.references = summarize(model).references;
  std::error_code unknown;
  const auto file =
      std::filesystem::temp_directory_path(unknown) / fmt::format("foldproof-bench-{}.model", getpid());
  FOLDPROOF_TRY(save_model(model, file.string()));
  row.model_bytes = static_cast<double>(std::filesystem::file_size(file, unknown));
  std::filesystem::remove(file, unknown);
  return model.charts;
}

// Both checkers take the same steps, one after the other.
Result<void> run_steps(Motion& motion, const std::shared_ptr<const Hierarchy>& hierarchy,
                       const std::shared_ptr<const ChartLibrary>& charts, const CertificatePlan& plan,
                       Row& row) {
  StepChecker with({charts ? Object(charts) : hierarchy}), without({hierarchy});
  StepSettings on, off;
  off.certificates = false;
  on.look_ahead = false;  // Else what one search saves later steps would pass for proven by certificates.
  StepResult result_on, result_off;
  StepLoader loader(motion);
  const LeafOwners owners(*hierarchy);
  const int parts = row.size == StepSize::Tenth ? 10 : 1;
  const Index all = (motion.frame_count() - 1) * parts;
  // What learns on the way gets its time; a motion too short for that is measured over its second half.
  const Index first = all == 1                         ? 0
                      : row.training == Training::None ? std::min(plan.learning_steps, all / 2)
                                                       : 1;
  for (Index k = 0; k < std::min(all, first + plan.steps); ++k) {
    if (auto loaded = loader.load({k / parts, static_cast<int>(k % parts), parts}); !loaded) return loaded;
    const std::span<const double> x0[] = {loader.x0()}, x1[] = {loader.x1()};
    const double start = now_milliseconds(plan.processor_time);
    if (auto done = without.check(x0, x1, off, result_off); !done) return done;
    const double middle = now_milliseconds(plan.processor_time);
    if (auto done = with.check(x0, x1, on, result_on); !done) return done;
    const double end = now_milliseconds(plan.processor_time);
    if (!same_answer(result_on, result_off))
      return fail(fmt::format("{}, step {}", row.scene, k), "has another answer with certificates",
                  "report this, please");
    if (k < first) continue;
    row.off += middle - start;
    row.on += end - middle;
    row.pairs_on += static_cast<double>(result_on.work.leaf_pairs);
    row.pairs_off += static_cast<double>(result_off.work.leaf_pairs);
    row.tests += static_cast<double>(result_on.work.certificate_tests);
    row.colliding += owners.colliding_pairs(result_off);
    ++row.steps;
  }
  return {};
}

// A motion of one step leaves nothing to learn: new checkers take it a few times, and the fastest counts.
Result<void> run_single(Motion& motion, const std::shared_ptr<const Hierarchy>& hierarchy,
                        const std::shared_ptr<const ChartLibrary>& charts, const CertificatePlan& plan,
                        Row& row) {
  Row best;
  for (int round = 0; round < 5; ++round) {
    Row once = row;
    if (auto done = run_steps(motion, hierarchy, charts, plan, once); !done) return done;
    if (round > 0) {
      once.on = std::min(once.on, best.on);
      once.off = std::min(once.off, best.off);
    }
    best = std::move(once);
  }
  row = std::move(best);
  return {};
}

Result<json> measure_row(const SceneInfo& scene, StepSize size, Training training,
                         const CertificatePlan& plan) {
  auto motion = FOLDPROOF_TRY(open_scene(scene));
  Row row;
  row.scene = scene.name;
  row.size = size;
  row.training = training;
  auto charts = FOLDPROOF_TRY(trained(scene, *motion, plan, row));
  std::shared_ptr<const Hierarchy> hierarchy;
  if (charts) {
    hierarchy = Object(charts).hierarchy();
  } else {
    auto built = FOLDPROOF_TRY(build_hierarchy(*motion, {}));
    hierarchy = std::move(built);
  }
  const auto run = size == StepSize::Full && motion->frame_count() == 2 ? run_single : run_steps;
  FOLDPROOF_TRY(run(*motion, hierarchy, charts, plan, row));
  return json{{"name", scene.name},
              {"kind", kind_name(scene.kind)},
              {"step", size_name(size)},
              {"training", name_of(training)},
              {"triangles", motion->topology().triangles().size()},
              {"references", row.references},
              {"train_seconds", row.train_seconds},
              {"model_bytes", row.model_bytes},
              {"steps", row.steps},
              {"milliseconds_with", row.on},
              {"milliseconds_without", row.off},
              {"leaf_pairs_with", row.pairs_on},
              {"leaf_pairs_without", row.pairs_off},
              {"colliding", row.colliding},
              {"certificate_tests", row.tests}};
}

}  // namespace

Result<json> compare_certificates(const std::vector<SceneInfo>& scenes, const CertificatePlan& plan) {
  json rows = json::array();
  for (const SceneInfo& scene : scenes) {
    for (const StepSize size : {StepSize::Full, StepSize::Tenth}) {
      for (const Training training : {Training::None, Training::EveryTenthFrame, Training::OwnPoses}) {
        if (training == Training::OwnPoses && separate_poses(scene.name).empty()) continue;
        if (training == Training::EveryTenthFrame && scene.kind == SceneKind::GroundTruth) continue;
        auto row = FOLDPROOF_TRY(measure_row(scene, size, training, plan));
        rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

}  // namespace foldproof::bench
