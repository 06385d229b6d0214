#include <nlohmann/json.hpp>

#include "foldproof/report.h"
#include "report/text_file.h"

namespace foldproof {
namespace {

using Json = nlohmann::ordered_json;

/// One line of JSON. File names need not be UTF-8; what is not becomes U+FFFD.
std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json to_json(const CollisionCounts& counts, bool poses) {
  Json json = {{"vf", counts.vertex_face}, {"ee", counts.edge_edge}};
  if (poses) json["tt"] = counts.triangle_triangle;
  return json;
}

Json to_json(const StageTimes& times) {
  return {{"total", times.total},
          {"update", times.update},
          {"traverse", times.traverse},
          {"narrow", times.narrow}};
}

Json to_json(const Work& work) {
  return {{"node_tests", work.node_tests},
          {"certificate_tests", work.certificate_tests},
          {"certificate_passes", work.certificate_passes},
          {"leaf_pairs", work.leaf_pairs},
          {"candidates_vf", work.candidates_vf},
          {"candidates_ee", work.candidates_ee},
          {"undecided", work.undecided}};
}

Json objects_json(Motions motions, const CheckSettings& settings) {
  Json objects = Json::array();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Motion& motion = *motions[i];
    const Model* model = i < settings.models.size() ? settings.models[i].get() : nullptr;
    objects.push_back({{"name", motion.name()},
                       {"vertices", motion.topology().vertex_count()},
                       {"triangles", motion.topology().triangles().size()},
                       {"frames", motion.frame_count()},
                       {"model", model ? Json(model->name) : Json(nullptr)}});
  }
  return objects;
}

Json settings_json(const ReportInfo& info, Index frame_count) {
  const CheckSettings& settings = info.settings;
  const std::vector<Index> frames = select_frames(settings.frames, frame_count);
  const auto end_frame = [&](bool last) {
    return frames.empty() ? 0 : last ? frames.back() : frames.front();
  };
  Json json = {
      {"static", settings.poses},
      {"frames", {{"first", end_frame(false)}, {"last", end_frame(true)}, {"step", settings.frames.step}}},
      {"substeps", settings.substeps},
      {"within", settings.step.within},
      {"between", settings.step.between},
      {"thickness", settings.step.thickness},
      {"tolerance", settings.step.tolerance},
      {"first", settings.step.earliest_only},
      {"certificates", settings.step.certificates},
      {"weld", info.read.weld},
      {"fps", info.read.fps}};
  if (settings.step.mode == Mode::Paper) {
    json["mode"] = "paper (STATISTICAL: can miss collisions)";
    json["miss_rate"] = settings.step.miss_rate;
  }
  return json;
}

class JsonReport : public ReportWriter {
 public:
  JsonReport(FileWriter file, Motions motions, const ReportInfo& info)
      : file_(std::move(file)),
        pairs_(info.pairs),
        poses_(info.settings.poses),
        statistical_(info.settings.step.mode == Mode::Paper) {
    const Index frame_count = motions.empty() ? 0 : motions[0]->frame_count();
    file_.add("{{\"foldproof\":{},\n\"objects\":{},\n\"settings\":{},\n\"steps\":[", dump(version()),
              dump(objects_json(motions, info.settings)), dump(settings_json(info, frame_count)));
  }

  Result<void> step(const CheckedStep& step) override {
    Json json = {{"frame", step.place.frame},
                 {"substep", step.place.substep},
                 {"collisions", to_json(step.collisions, poses_)},
                 {"earliest_toi", step.earliest_toi},
                 {"milliseconds", to_json(step.milliseconds)},
                 {"work", to_json(step.work)}};
    add_misses(json, step.missed, step.proven_milliseconds);
    std::string text = dump(json);
    text.pop_back();  // The pairs may follow before the closing brace.
    file_.add("{}\n{}", step.place.number == 0 ? "" : ",", text);
    if (pairs_) {
      file_.add(",\"pairs\":{{");
      auto done = step.pose ? add_pairs(*step.pose) : add_pairs(*step.step);
      if (!done) return done;
      file_.add("}}");
    }
    file_.add("}}");
    return file_.flush_if_large();
  }

  Result<void> finish(const CheckTotals& totals) override {
    Json json = {{"steps", totals.steps},
                 {"steps_with_collisions", totals.steps_with_collisions},
                 {"collisions", to_json(totals.collisions, poses_)},
                 {"earliest", nullptr},
                 {"worst", nullptr},
                 {"tolerance", totals.tolerance},
                 {"milliseconds", to_json(totals.milliseconds)},
                 {"work", to_json(totals.work)}};
    add_misses(json, totals.missed, totals.proven_milliseconds);
    if (totals.earliest) {
      json["earliest"] = {{"frame", totals.earliest->frame},
                          {"substep", totals.earliest->substep},
                          {"toi", totals.earliest_toi}};
    }
    if (totals.worst) {
      json["worst"] = {{"frame", totals.worst->frame},
                       {"substep", totals.worst->substep},
                       {"collisions", to_json(totals.worst_collisions, poses_)}};
    }
    file_.add("\n],\n\"totals\":{},\n\"clean\":{}}}\n", dump(json), totals.clean());
    return file_.commit();
  }

 private:
  void add_misses(Json& json, std::uint64_t missed, double proven_milliseconds) const {
    if (!statistical_) return;
    json["missed"] = missed;
    json["proven_milliseconds"] = proven_milliseconds;
  }

  Result<void> add_pairs(const StepResult& result) {
    file_.add("\"vf\":[");
    const char* separator = "";
    for (const VertexFaceCollision& c : result.vertex_face) {
      file_.add("{}[{},{},{},{},{}]", separator, c.vertex_object, c.vertex, c.face_object, c.face, c.toi);
      separator = ",";
      if (auto done = file_.flush_if_large(); !done) return done;
    }
    file_.add("],\"ee\":[");
    separator = "";
    for (const EdgeEdgeCollision& c : result.edge_edge) {
      file_.add("{}[{},{},{},{},{},{},{}]", separator, c.object_a, c.a[0], c.a[1], c.object_b, c.b[0], c.b[1],
                c.toi);
      separator = ",";
      if (auto done = file_.flush_if_large(); !done) return done;
    }
    file_.add("]");
    return {};
  }

  Result<void> add_pairs(const StaticResult& result) {
    file_.add("\"vf\":[],\"ee\":[],\"tt\":[");
    const char* separator = "";
    for (const TriangleCrossing& c : result.crossings) {
      file_.add("{}[{},{},{},{}]", separator, c.object_a, c.triangle_a, c.object_b, c.triangle_b);
      separator = ",";
      if (auto done = file_.flush_if_large(); !done) return done;
    }
    file_.add("]");
    return {};
  }

  TextFile file_;
  bool pairs_, poses_, statistical_;
};

}  // namespace

Result<std::unique_ptr<ReportWriter>> json_report(const std::string& path, Motions motions,
                                                  const ReportInfo& info) {
  auto file = FileWriter::open(path);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<JsonReport>(std::move(*file), motions, info);
}

}  // namespace foldproof
