#include "page/scene_data.h"

#include <algorithm>
#include <limits>

#include "base/try.h"
#include "learned/certificates.h"
#include "report/assumed.h"

namespace foldproof {

const Predictor& PageObject::predictor() const {
  std::call_once(once_, [&] { predictor_ = std::make_unique<const Predictor>(model->learned); });
  return *predictor_;
}

Result<std::unique_ptr<SceneData>> SceneData::open(PageInput input) {
  std::unique_ptr<SceneData> scene(new SceneData);
  scene->settings_ = std::move(input.check);
  scene->read_ = input.read;
  scene->cancels_ = !input.repair_progress;
  CheckSettings& settings = scene->settings_;
  auto frames = FOLDPROOF_TRY(frames_to_check(input.motions, settings));
  FOLDPROOF_TRY(require_models_of(input.motions, settings));
  scene->frames_ = std::move(frames);
  settings.step.explain = true;
  scene->low_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  scene->high_ = -scene->low_;
  for (auto& motion : input.motions)
    scene->motions_.push_back(std::make_unique<SharedMotion>(std::move(motion)));
  for (Index i = 0; i < scene->motions_.size(); ++i) {
    FOLDPROOF_TRY(scene->add(i));
  }
  return scene;
}

Result<void> SceneData::add(Index i) {
  auto object = std::make_unique<PageObject>();
  object->motion = static_cast<SharedMotion*>(motions_[i].get());
  const auto frame = FOLDPROOF_TRY(object->motion->frame(frames_[0]));
  if (!settings_.models.empty()) object->model = settings_.models[i];
  if (object->model) {
    object->hierarchy = object->model->hierarchy();
  } else {
    auto built = Hierarchy::build(object->motion->topology(), *frame);
    if (!built)
      return fail(built.error().code, object->motion->name() + ": " + built.error().where,
                  built.error().problem, built.error().remedy);
    object->hierarchy = std::make_shared<const Hierarchy>(std::move(*built));
  }
  settings_.hierarchies.push_back(object->hierarchy);
  object->depths = depths_of(*object->hierarchy);
  object->levels = *std::max_element(object->depths.begin(), object->depths.end());
  for (std::size_t i = 0; i < frame->size(); i += 3) {
    const Vec3 x = Vec3::load(&(*frame)[i]);
    low_ = low_.cwiseMin(x);
    high_ = high_.cwiseMax(x);
  }
  objects_.push_back(std::move(object));
  return {};
}

std::uint64_t SceneData::steps() const {
  if (settings_.poses || frames_.size() == 1) return frames_.size();
  return (frames_.size() - 1) * std::uint64_t{settings_.substeps};
}

std::vector<ScenePart> SceneData::parts() const {
  std::vector<ScenePart> parts;
  for (Index i = 0; i < objects_.size(); ++i) {
    for (Index part = 0; part < parts_of(i, motions_, settings_).names.size(); ++part)
      parts.push_back({i, part});
  }
  return parts;
}

Json SceneData::json() const {
  Json objects = Json::array();
  for (const auto& object : objects_) {
    objects.push_back({{"name", object->motion->name()},
                       {"vertices", object->motion->topology().vertex_count()},
                       {"triangles", object->motion->topology().triangles().size()},
                       {"levels", object->levels},
                       {"notes", object->motion->info().notes},
                       {"unchecked", object->motion->info().unchecked},
                       {"model", model_json(object->model.get())}});
  }
  Json part_list = Json::array();
  for (const ScenePart& part : parts())
    part_list.push_back({{"object", part.object}, {"name", part_name(part)}});
  Json frame_names = Json::array();
  const auto& names = motions_.front()->info().frame_names;
  for (const Index k : frames_)
    if (k < names.size()) frame_names.push_back(names[k]);
  const StepSettings& s = settings_.step;
  return {{"program", "foldproof"},
          {"version", version()},
          {"title", title_of(motions_)},
          {"frames", frames_.size()},
          {"frame_numbers", frames_},
          {"frame_names", frame_names},
          {"fps", read_.fps},
          {"substeps", settings_.substeps},
          {"steps", steps()},
          {"assumed", assumed(motions_, settings_.poses)},
          {"objects", std::move(objects)},
          {"parts", std::move(part_list)},
          {"center", {center().x(), center().y(), center().z()}},
          {"low", {low_.x(), low_.y(), low_.z()}},
          {"high", {high_.x(), high_.y(), high_.z()}},
          {"settings",
           {{"static", settings_.poses},
            {"thickness", s.thickness},
            {"tolerance", s.tolerance},
            {"within", s.within},
            {"between", s.between},
            {"certificates", s.certificates},
            {"steps_only", settings_.steps_only},
            {"ignore", settings_.ignore},
            {"unit", unit_of(motions_, settings_)},
            {"mode", settings_.paper_miss_rate ? "paper" : "proven"}}},
          {"reasons", kReasonNames},
          {"cancels", cancels_}};
}

Result<std::vector<float>> SceneData::boxes(Index i, Index k, Index level) const {
  const auto x = FOLDPROOF_TRY(frame(i, k));
  const PageObject& object = *objects_[i];
  const Hierarchy& h = *object.hierarchy;
  std::vector<float> boxes;
  for (Index n = 0; n < h.nodes().size(); ++n) {
    const Hierarchy::Node& node = h.nodes()[n];
    if (object.depths[n] != level && !(node.is_leaf() && object.depths[n] < level)) continue;
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    const Index end = h.leaves()[node.leaf_end].triangles;
    for (Index t = h.leaves()[node.leaf_begin].triangles; t < end; ++t) {
      for (const Index v : h.topology().triangles()[h.triangle_ids()[t]]) {
        const Vec3 corner = Vec3::load(&(*x)[3 * std::size_t{v}]);
        low = low.cwiseMin(corner);
        high = high.cwiseMax(corner);
      }
    }
    // Subtraction and rounding are monotonic, so a rounded box still contains its rounded vertices.
    for (const Vec3& corner : {low, high}) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        boxes.push_back(static_cast<float>(corner[axis] - center()[axis]));
    }
  }
  return boxes;
}

}  // namespace foldproof
