#include "report/json_values.h"

#include <algorithm>

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
  return {{"refits", work.refits},
          {"node_tests", work.node_tests},
          {"certificate_tests", work.certificate_tests},
          {"certificate_passes", work.certificate_passes},
          {"leaf_pairs", work.leaf_pairs},
          {"candidates_vf", work.candidates_vf},
          {"candidates_ee", work.candidates_ee},
          {"undecided", work.undecided}};
}

const char* name_of(Weld weld) {
  if (weld == Weld::ByFormat) return "by_format";
  return weld == Weld::Always ? "always" : "never";
}

namespace {

std::uint64_t merged_count(const Motion& motion) {
  const auto& merged = motion.info().merged;
  std::uint64_t count = 0;
  for (std::size_t v = 0; v < merged.size(); ++v) count += merged[v] != v;
  return count;
}

}  // namespace

Json objects_json(Motions motions, const CheckSettings& settings) {
  Json objects = Json::array();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Motion& motion = *motions[i];
    const Model* model = i < settings.models.size() ? settings.models[i].get() : nullptr;
    objects.push_back({{"name", motion.name()},
                       {"vertices", motion.topology().vertex_count()},
                       {"triangles", motion.topology().face_count()},
                       {"frames", motion.frame_count()},
                       {"merged", merged_count(motion)},
                       {"model", model ? Json(model->name) : Json(nullptr)}});
    const Topology& topology = motion.topology();
    if (topology.line_count() > 0) objects.back()["lines"] = topology.line_count();
    if (topology.point_count() > 0) objects.back()["points"] = topology.point_count();
    if (const auto& notes = motion.info().notes; !notes.empty()) objects.back()["notes"] = notes;
    if (const auto& taken_as = motion.info().taken_as; !taken_as.empty())
      objects.back()["taken_as"] = taken_as;
    if (const auto& unchecked = motion.info().unchecked; !unchecked.empty())
      objects.back()["unchecked"] = unchecked;
  }
  return objects;
}

Json settings_json(const ReportInfo& info, Motions motions) {
  const CheckSettings& settings = info.settings;
  const std::vector<Index> frames =
      select_frames(settings.frames, motions.empty() ? 0 : motions[0]->frame_count());
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
               {"ignore", settings.ignore},
               {"still_pairs", settings.still_pairs},
               {"weld", info.read.weld == Weld::Always},
               {"seams", name_of(info.read.weld)},
               {"points", info.read.points},
               {"fps", info.read.fps}};
  if (const std::string unit = unit_of(motions, settings); !unit.empty()) json["unit"] = unit;
  if (settings.paper_miss_rate) {
    json["mode"] = "paper (STATISTICAL: can miss collisions)";
    json["miss_rate"] = *settings.paper_miss_rate;
  }
  return json;
}

void add_misses(Json& json, std::uint64_t missed, double proven_milliseconds) {
  json["missed"] = missed;
  json["proven_milliseconds"] = proven_milliseconds;
}

namespace {

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json to_json(const Vec3& v) { return Json::array({v[0], v[1], v[2]}); }

Json to_json(const ContactFrame& frame) {
  return {{"time", frame.time},
          {"crossings", frame.crossings},
          {"triangles", frame.triangles},
          {"curve_length", frame.curve_length},
          {"closed", frame.closed},
          {"area", Json::array({number_or_null(frame.area[0]), number_or_null(frame.area[1])})},
          {"depth", number_or_null(frame.depth)},
          {"at_least", frame.at_least},
          {"touching", frame.touching}};
}

}  // namespace

Json contact_json(const Contact& contact, const std::array<std::string, 2>& names,
                  const GroupOfContact& group, bool lists) {
  Json frames = Json::array(), sides = Json::array(), curves = Json::array();
  for (const ContactFrame& frame : contact.frames) frames.push_back(to_json(frame));
  for (std::size_t side = 0; side < 2; ++side) {
    const Contact::Side& s = contact.sides[side];
    sides.push_back({{"object", s.object}, {"name", names[side]}});
    if (lists) sides.back().update({{"triangles", s.triangles}, {"inside", s.inside}});
  }
  Json json = {{"number", contact.number},
               {"joined", contact.joined},
               {"group", group.number},
               {"often", group.often},
               {"named", has_names(contact)},
               {"sides", sides},
               {"folded", contact.folded},
               {"pierces", contact.pierces},
               {"from_start", contact.from_start},
               {"healed", contact.healed},
               {"first_time", contact.first_time},
               {"last_time", contact.last_time},
               {"pairs", contact.pairs},
               {"depth", number_or_null(contact.depth())},
               {"at_least", contact.at_least()},
               {"touching", contact.touching()},
               {"worst", contact.frames.empty() ? Json(nullptr) : Json(contact.frames[contact.worst].time)},
               {"point", to_json(contact.point)},
               {"box", Json::array({to_json(contact.low), to_json(contact.high)})},
               {"normal", to_json(contact.normal)},
               {"frames", frames}};
  if (!lists) return json;
  for (const auto& curve : contact.curves) {
    Json points = Json::array();
    for (const Vec3& point : curve) points.push_back(to_json(point));
    curves.push_back(std::move(points));
  }
  json["curves"] = std::move(curves);
  return json;
}

Json verdict_json(const CheckVerdict& verdict) {
  constexpr std::array<const char*, 3> kKinds{"free", "found", "limited"};
  Json parts = Json::array();
  for (const auto& piece : verdict.sentence.pieces())
    std::visit([&](const auto& each) { parts.push_back(each); }, piece);
  return {{"text", verdict.sentence.text()},
          {"parts", parts},
          {"kind", kKinds[static_cast<std::size_t>(verdict.kind)]},
          {"numbers", verdict.numbers},
          {"whole", verdict.whole}};
}

namespace {

// What crosses among what stands still.
Json still_json(const CheckTotals& totals) {
  Json pairs = Json::array();
  for (const auto& [a, b, crossings] : totals.still_crossings)
    pairs.push_back({{"objects", {a, b}}, {"crossings", crossings}});
  return {{"objects", totals.still},
          {"crossings", totals.still_crossing ? Json(*totals.still_crossing) : Json(nullptr)},
          {"pairs", pairs}};
}

}  // namespace

Json totals_json(const CheckTotals& totals, bool poses, bool statistical) {
  Json json = {{"steps", totals.steps},
               {"steps_expected", totals.steps_expected},
               {"stopped", totals.cancelled},
               {"steps_with_collisions", totals.steps_with_collisions},
               {"collisions", to_json(totals.collisions, poses)},
               {"starts_crossing", totals.starts_crossing ? Json(*totals.starts_crossing) : Json(nullptr)},
               {"still", still_json(totals)},
               {"earliest", nullptr},
               {"worst", nullptr},
               {"tolerance", totals.tolerance},
               {"milliseconds", to_json(totals.milliseconds)},
               {"work", to_json(totals.work)}};
  for (const auto& [object, text] : totals.notices)
    json["notices"].push_back({{"object", object}, {"text", text}});
  if (!totals.lists_all()) json["listed"] = to_json(totals.listed, poses);
  if (statistical) add_misses(json, totals.missed, totals.proven_milliseconds);
  if (totals.contacts_found) {
    std::optional<double> deepest;
    for (const Contact& contact : totals.contacts) deepest = std::max(deepest, contact.depth());
    json["contacts"] = {{"count", totals.contacts.size()},
                        {"depth", number_or_null(deepest)},
                        {"unknown_frames", totals.contact_unknown_frames},
                        {"milliseconds", {{"total", totals.contact_milliseconds}}}};
  }
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
