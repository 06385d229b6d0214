#include "page/page_json.h"

#include <fmt/format.h>

#include <filesystem>
#include <new>

namespace foldproof {

Json step_json(const StepRecord& s) {
  const auto number = [](const std::optional<std::uint64_t>& n) { return n ? Json(*n) : Json(nullptr); };
  return {{"number", s.index.number},
          {"frame", s.index.frame},
          {"next_frame", s.index.next_frame},
          {"substep", s.index.substep},
          {"vertex_face", s.collisions.vertex_face},
          {"edge_edge", s.collisions.edge_edge},
          {"crossings", s.collisions.triangle_triangle},
          {"listed", s.listed},
          {"inside", Json::array({number(s.inside[0]), number(s.inside[1])})},
          {"undecided", s.work.undecided},
          {"toi", s.earliest_toi},
          {"tolerance", s.tolerance},
          {"node_tests", s.work.node_tests},
          {"certificate_tests", s.work.certificate_tests},
          {"certificate_passes", s.work.certificate_passes},
          {"leaf_pairs", s.work.leaf_pairs},
          {"candidates", s.work.candidates_vf + s.work.candidates_ee},
          {"reasons", s.leaf_pairs},
          {"ms", to_json(s.milliseconds)}};
}

Json start_json(const StartRecord& s) {
  return {
      {"frame", s.frame}, {"crossings", s.crossings}, {"listed", s.listed}, {"ms", to_json(s.milliseconds)}};
}

Json contact_json(const ContactPoint& c) {
  constexpr std::array<const char*, 3> kKinds{"vf", "ee", "tt"};
  const auto ids = [&](const std::array<Index, 2>& pair) {
    return c.kind == PairKind::EdgeEdge ? Json(pair) : Json::array({pair[0]});
  };
  const char* answer = c.answer == Answer::Hit ? "hit" : "undecided";
  return {{"kind", kKinds[static_cast<std::size_t>(c.kind)]},
          {"object_a", c.object_a},
          {"a", ids(c.a)},
          {"object_b", c.object_b},
          {"b", ids(c.b)},
          {"toi", c.toi},
          {"answer", c.kind == PairKind::Triangles ? "crossing" : answer},
          {"point", c.point}};
}

Json model_json(const Model* model) {
  if (model == nullptr) return nullptr;
  Json deviations = Json::array(), energy = Json::array(), key_points = Json::array();
  Index modes = 0;
  if (const Learned* learned = model->learned.get()) {
    modes = learned->pca.modes();
    for (const double d : learned->pca.deviations) deviations.push_back(d);
    for (const double e : learned->pca.energy) energy.push_back(e);
    for (const Index v : learned->key_points.vertices) key_points.push_back(v);
  }
  return {{"name", model->name}, {"modes", modes},           {"deviations", deviations},
          {"energy", energy},    {"key_points", key_points}, {"poses", model->poses.size()}};
}

std::string error_json(const std::string& line) { return dump({{"error", line}}); }

std::string line_of(const std::exception& thrown) {
  if (dynamic_cast<const std::bad_alloc*>(&thrown) != nullptr)
    return "memory: there is not enough; view fewer objects at a time";
  return Error{"the page", fmt::format("failed: {}", thrown.what()), "please report this"}.line();
}

std::string title_of(Motions motions) {
  std::string title = std::filesystem::path(motions[0]->name()).filename().string();
  if (title.empty()) title = motions[0]->name();
  if (motions.size() > 1) title += fmt::format(" and {} more", motions.size() - 1);
  return title;
}

}  // namespace foldproof
