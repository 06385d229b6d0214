#include "report/json_values.h"

namespace foldproof {

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
  const Index first = frames.empty() ? 0 : frames.front(), last = frames.empty() ? 0 : frames.back();
  Json json = {{"static", settings.poses},
               {"frames", {{"first", first}, {"last", last}, {"step", settings.frames.step}}},
               {"substeps", settings.substeps},
               {"steps_only", settings.steps_only},
               {"within", settings.step.within},
               {"between", settings.step.between},
               {"thickness", settings.step.thickness},
               {"tolerance", settings.step.tolerance},
               {"first", settings.step.earliest_only},
               {"limit", settings.step.max_listed},
               {"certificates", settings.step.certificates},
               {"weld", info.read.weld},
               {"fps", info.read.fps}};
  if (settings.step.mode == Mode::Paper) {
    json["mode"] = "paper (STATISTICAL: can miss collisions)";
    json["miss_rate"] = settings.step.miss_rate;
  }
  return json;
}

void add_misses(Json& json, std::uint64_t missed, double proven_milliseconds) {
  json["missed"] = missed;
  json["proven_milliseconds"] = proven_milliseconds;
}

Json totals_json(const CheckTotals& totals, bool poses, bool statistical) {
  Json json = {{"steps", totals.steps},
               {"steps_expected", totals.steps_expected},
               {"stopped", totals.cancelled},
               {"steps_with_collisions", totals.steps_with_collisions},
               {"collisions", to_json(totals.collisions, poses)},
               {"starts_crossing", totals.starts_crossing ? Json(*totals.starts_crossing) : Json(nullptr)},
               {"earliest", nullptr},
               {"worst", nullptr},
               {"tolerance", totals.tolerance},
               {"milliseconds", to_json(totals.milliseconds)},
               {"work", to_json(totals.work)}};
  if (totals.listed.sum() < totals.collisions.sum()) json["listed"] = to_json(totals.listed, poses);
  if (statistical) add_misses(json, totals.missed, totals.proven_milliseconds);
  if (totals.earliest) {
    json["earliest"] = {{"frame", totals.earliest->frame},
                        {"substep", totals.earliest->substep},
                        {"toi", totals.earliest_toi}};
  }
  if (totals.worst) {
    json["worst"] = {{"frame", totals.worst->frame},
                     {"substep", totals.worst->substep},
                     {"collisions", to_json(totals.worst_collisions, poses)}};
  }
  return json;
}

}  // namespace foldproof
