// The functions of the npm package (npm/), for JavaScript. Settings and answers are JSON; the arrays of an
// answer lie behind foldproof_arrays().
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>

#include "base/try.h"
#include "report/contact_groups.h"
#include "report/json_values.h"
#include "report/report.h"

namespace foldproof {
namespace {

constexpr int kFailed = -1, kEnded = 0, kMore = 1;

// The last answer.
Json answer;
std::string answer_text;
std::vector<double> answer_arrays;  // doubles, so that every array is aligned

template <class T>
constexpr const char* kArrayType = nullptr;
template <>
constexpr const char* kArrayType<std::uint8_t> = "Uint8Array";
template <>
constexpr const char* kArrayType<Index> = "Uint32Array";
template <>
constexpr const char* kArrayType<double> = "Float64Array";

/// Appends `values` to the answer's arrays; its place there, in bytes.
template <class T>
Json array_json(const std::vector<T>& values) {
  const std::size_t at = answer_arrays.size() * sizeof(double), bytes = values.size() * sizeof(T);
  answer_arrays.resize(answer_arrays.size() + (bytes + sizeof(double) - 1) / sizeof(double));
  if (bytes > 0) std::memcpy(reinterpret_cast<char*>(answer_arrays.data()) + at, values.data(), bytes);
  return {{"array", kArrayType<T>}, {"at", at}, {"length", values.size()}};
}

/// A field of all rows; of an edge, both ends.
template <class Row, class Field>
Json column(const std::vector<Row>& rows, Field Row::*field) {
  if constexpr (std::is_same_v<Field, Edge>) {
    std::vector<Index> values;
    values.reserve(2 * rows.size());
    for (const Row& row : rows) values.insert(values.end(), (row.*field).begin(), (row.*field).end());
    return array_json(values);
  } else {
    std::vector<Field> values;
    values.reserve(rows.size());
    for (const Row& row : rows) values.push_back(row.*field);
    return array_json(values);
  }
}

template <class Row>
Json undecided(const std::vector<Row>& rows) {
  std::vector<std::uint8_t> values;
  values.reserve(rows.size());
  for (const Row& row : rows) values.push_back(row.answer == Answer::Undecided ? 1 : 0);
  return array_json(values);
}

Json to_json(const std::vector<VertexFaceCollision>& rows) {
  using Row = VertexFaceCollision;
  return {{"vertexObject", column(rows, &Row::vertex_object)},
          {"vertex", column(rows, &Row::vertex)},
          {"faceObject", column(rows, &Row::face_object)},
          {"face", column(rows, &Row::face)},
          {"toi", column(rows, &Row::toi)},
          {"undecided", undecided(rows)}};
}

Json to_json(const std::vector<EdgeEdgeCollision>& rows) {
  using Row = EdgeEdgeCollision;
  return {{"objectA", column(rows, &Row::object_a)}, {"a", column(rows, &Row::a)},
          {"objectB", column(rows, &Row::object_b)}, {"b", column(rows, &Row::b)},
          {"toi", column(rows, &Row::toi)},          {"undecided", undecided(rows)}};
}

Json to_json(const std::vector<TriangleCrossing>& rows) {
  using Row = TriangleCrossing;
  return {{"objectA", column(rows, &Row::object_a)},
          {"triangleA", column(rows, &Row::triangle_a)},
          {"objectB", column(rows, &Row::object_b)},
          {"triangleB", column(rows, &Row::triangle_b)}};
}

/// Per object, a mark for each face that collides.
template <class Topologies, class Result>
Json colliding_faces_json(const Topologies& topologies, const Result& result) {
  Json objects = Json::array();
  for (Index object = 0; object < topologies.size(); ++object)
    objects.push_back(array_json(colliding_faces(*topologies[object], object, result)));
  return objects;
}

/// What a step's answer and a pose's have in common.
template <class Topologies, class Result>
Json result_json(const Topologies& topologies, const Result& result) {
  Json json = {{"clean", result.clean()},
               {"milliseconds", result.milliseconds.total},
               {"collidingFaces", colliding_faces_json(topologies, result)}};
  if constexpr (std::is_same_v<Result, StepResult>) {
    json["vertexFaceCount"] = result.vertex_face_count;
    json["edgeEdgeCount"] = result.edge_edge_count;
    json["vertexFace"] = to_json(result.vertex_face);
    json["edgeEdge"] = to_json(result.edge_edge);
    json["earliestToi"] = result.earliest_toi;
    json["tolerance"] = result.tolerance;
  } else {
    json["crossingCount"] = result.crossing_count;
    json["crossings"] = to_json(result.crossings);
  }
  return json;
}

/// `values`: the settings of the package's StepSettings, all of them.
StepSettings step_settings(const Json& values) {
  StepSettings step;
  step.within = values["within"];
  step.between = values["between"];
  step.thickness = values["thickness"];
  step.tolerance = values["tolerance"];
  step.certificates = values["certificates"];
  step.max_listed = values["maxListed"];
  return step;
}

/// Meshes with their frames, as they come.
struct Meshes {
  std::vector<std::string> names;
  std::vector<Topology> topologies;
  std::vector<ObjectParts> parts;
  std::vector<std::vector<std::vector<double>>> frames;
};

using Topologies = std::vector<const Topology*>;

/// Makes each answer of a MotionCheck the answer.
class AnswerWriter final : public ReportWriter {
 public:
  AnswerWriter(Motions motions, const CheckSettings& settings) : motions_(motions), settings_(settings) {
    for (const auto& motion : motions) topologies_.push_back(&motion->topology());
  }

  Result<void> start(const CheckedStep& pose) override {
    answer = {{"start", result_json(topologies_, *pose.pose)}};
    return {};
  }
  Result<void> step(const CheckedStep& step) override {
    Json json =
        step.pose != nullptr ? result_json(topologies_, *step.pose) : result_json(topologies_, *step.step);
    json.update({{"number", step.index.number},
                 {"frame", step.index.frame},
                 {"nextFrame", step.index.next_frame},
                 {"substep", step.index.substep}});
    answer = {{"step", std::move(json)}};
    return {};
  }
  Result<void> finish(const CheckTotals& totals) override {
    Json contacts = Json::array();
    const auto groups = groups_of(totals.contacts);
    for (std::size_t k = 0; k < groups.size(); ++k) {
      const Contact& contact = totals.contacts[k];
      contacts.push_back(contact_json(contact, side_names(contact, motions_, settings_), groups[k], true));
    }
    answer = {{"end",
               {{"clean", totals.clean()},
                {"collisions", totals.collisions.sum()},
                {"listed", totals.listed.sum()},
                {"startsCrossing", totals.starts_crossing ? Json(*totals.starts_crossing) : Json(nullptr)},
                {"tolerance", totals.tolerance},
                {"contacts", std::move(contacts)},
                {"unknownFrames", totals.contact_unknown_frames},
                {"steps", totals.steps}}}};
    return {};
  }

 private:
  Motions motions_;
  const CheckSettings& settings_;
  Topologies topologies_;
};

/// A check of whole motions.
struct Check {
  std::vector<std::unique_ptr<Motion>> motions;
  CheckSettings settings;
  std::vector<std::unique_ptr<ReportWriter>> writers;
  std::optional<MotionCheck> check;
};

Result<std::unique_ptr<Check>> open_check(Meshes meshes, const Json& settings) {
  auto check = std::make_unique<Check>();
  for (std::size_t i = 0; i < meshes.names.size(); ++i)
    check->motions.push_back(
        memory_motion(meshes.names[i], std::move(meshes.topologies[i]), std::move(meshes.frames[i])));
  check->settings.step = step_settings(settings);
  check->settings.parts = std::move(meshes.parts);
  check->settings.poses = settings["static"];
  check->settings.steps_only = settings["stepsOnly"];
  check->settings.contacts = settings["contacts"];
  check->settings.substeps = settings["substeps"];
  check->writers.push_back(std::make_unique<AnswerWriter>(check->motions, check->settings));
  check->check = FOLDPROOF_TRY(MotionCheck::make(check->motions, check->settings, check->writers));
  return check;
}

/// Checks step by step.
struct Checker {
  std::vector<Object> objects;
  Topologies topologies;
  std::optional<StepChecker> checker;
  StepResult step;
  StaticResult pose;
};

Result<std::unique_ptr<Checker>> open_checker(Meshes meshes) {
  auto checker = std::make_unique<Checker>();
  for (std::size_t i = 0; i < meshes.names.size(); ++i) {
    checker->objects.emplace_back(
        FOLDPROOF_TRY(Hierarchy::build(std::move(meshes.topologies[i]), meshes.frames[i].front())));
    checker->topologies.push_back(&checker->objects.back().hierarchy()->topology());
  }
  checker->checker.emplace(checker->objects);
  return checker;
}

/// Positions of all objects, one after the other.
std::vector<std::span<const double>> positions_of(const Checker& checker, const double* x) {
  std::vector<std::span<const double>> all;
  for (const Topology* topology : checker.topologies) {
    all.emplace_back(x, 3 * std::size_t{topology->vertex_count()});
    x += all.back().size();
  }
  return all;
}

/// Runs `body`; an error becomes the answer.
template <class Body>
int attempt(Body body) {
  answer = Json::object();
  answer_arrays.clear();
  const auto refused = [](const Error& error) {
    answer = {{"where", error.where}, {"problem", error.problem}, {"remedy", error.remedy}};
    return kFailed;
  };
  try {
    const Result<int> done = body();
    return done ? *done : refused(done.error());
  } catch (const std::bad_alloc&) {
    return refused({"memory", "is not enough", "check fewer frames or a part of the mesh at a time"});
  } catch (const std::exception& failure) {
    return refused({"foldproof", std::string("failed: ") + failure.what(), "report this with its input"});
  }
}

}  // namespace
}  // namespace foldproof

// Handles are pointers; foldproof_drop_* ends their life. Functions return -1 and an error as the answer; or
// 0; or 1 where there is more to do.
extern "C" {
using namespace foldproof;

const char* foldproof_answer() {
  answer_text = dump(answer);
  return answer_text.c_str();
}
const double* foldproof_arrays() { return answer_arrays.data(); }

Meshes* foldproof_meshes() { return new Meshes; }
void foldproof_drop_meshes(Meshes* meshes) { delete meshes; }

/// `parts`: their names, as JSON; `part_of_triangle` may be null.
int foldproof_add_mesh(Meshes* meshes, const char* name, const Triangle* triangles, std::size_t count,
                       Index vertices, const char* parts, const Index* part_of_triangle) {
  return attempt([&]() -> Result<int> {
    auto topology = Topology::make(vertices, {triangles, triangles + count});
    if (!topology) return tl::unexpected(std::move(topology.error()));
    meshes->topologies.push_back(std::move(*topology));
    meshes->names.emplace_back(name);
    meshes->parts.push_back({Json::parse(parts), {}});
    if (part_of_triangle != nullptr)
      meshes->parts.back().of_triangle.assign(part_of_triangle, part_of_triangle + count);
    meshes->frames.emplace_back();
    return kEnded;
  });
}

/// A frame of the last mesh.
int foldproof_add_frame(Meshes* meshes, const double* x) {
  return attempt([&]() -> Result<int> {
    meshes->frames.back().emplace_back(x, x + 3 * std::size_t{meshes->topologies.back().vertex_count()});
    return kEnded;
  });
}

/// Takes the frames out of `meshes`. The answer: {"check": handle}.
int foldproof_open_check(Meshes* meshes, const char* settings) {
  return attempt([&]() -> Result<int> {
    auto check = FOLDPROOF_TRY(open_check(std::move(*meshes), Json::parse(settings)));
    answer = {{"handle", reinterpret_cast<std::uintptr_t>(check.release())}};
    return kEnded;
  });
}
void foldproof_drop_check(Check* check) { delete check; }

/// The next part. The answer: {"start": pose}, {"step": step}, {"end": totals} or {}.
int foldproof_advance(Check* check) {
  return attempt([&]() -> Result<int> { return FOLDPROOF_TRY(check->check->advance()) ? kMore : kEnded; });
}

/// As foldproof_open_check, with the first frames.
int foldproof_open_checker(Meshes* meshes) {
  return attempt([&]() -> Result<int> {
    auto checker = FOLDPROOF_TRY(open_checker(std::move(*meshes)));
    answer = {{"handle", reinterpret_cast<std::uintptr_t>(checker.release())}};
    return kEnded;
  });
}
void foldproof_drop_checker(Checker* checker) { delete checker; }

/// `x0`, `x1`: positions of all objects, one after the other.
int foldproof_check_step(Checker* checker, const double* x0, const double* x1, const char* settings) {
  return attempt([&]() -> Result<int> {
    FOLDPROOF_TRY(checker->checker->check(positions_of(*checker, x0), positions_of(*checker, x1),
                                          step_settings(Json::parse(settings)), checker->step));
    answer = result_json(checker->topologies, checker->step);
    return kEnded;
  });
}

int foldproof_check_pose(Checker* checker, const double* x, const char* settings) {
  return attempt([&]() -> Result<int> {
    FOLDPROOF_TRY(checker->checker->check_static(positions_of(*checker, x),
                                                 step_settings(Json::parse(settings)), checker->pose));
    answer = result_json(checker->topologies, checker->pose);
    return kEnded;
  });
}
}
