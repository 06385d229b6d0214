/// The data of a page that does not change: motions, models, hierarchies.
#pragma once

#include <mutex>

#include "page/page.h"
#include "page/page_json.h"
#include "page/shared_motion.h"

namespace foldproof {

/// An object of the scene.
struct PageObject {
  SharedMotion* motion = nullptr;
  std::shared_ptr<const Model> model;  ///< Null if there is none.
  std::shared_ptr<const Hierarchy> hierarchy;
  std::vector<Index> depths;  ///< Per node of the hierarchy.
  Index levels = 0;           ///< The largest depth.

  const Learned* learned() const { return model ? model->learned.get() : nullptr; }
  const Predictor& predictor() const;  ///< Precondition: learned().

 private:
  mutable std::once_flag once_;
  mutable std::unique_ptr<const Predictor> predictor_;
};

/// A part of an object.
struct ScenePart {
  Index object = 0, part = 0;
};

/// Immutable, apart from a cache of frames. Thread-safe.
class SceneData {
 public:
  static Result<std::unique_ptr<SceneData>> open(PageInput input);

  Motions motions() const { return motions_; }
  const CheckSettings& settings() const { return settings_; }
  const ReadOptions& read() const { return read_; }
  std::span<const std::unique_ptr<PageObject>> objects() const { return objects_; }
  std::span<const Index> frames() const { return frames_; }
  /// In a static check every frame is one; else 1 for a single frame: a step without motion.
  std::uint64_t steps() const;

  /// The middle of the first frame. Positions are sent relative to it, as single precision is fine near 0.
  Vec3 center() const { return (low_ + high_) / 2; }

  /// Of all objects, one after the other.
  std::vector<ScenePart> parts() const;
  const std::string& part_name(const ScenePart& part) const {
    return parts_of(part.object, motions_, settings_).names[part.part];
  }
  Json json() const;
  Result<SharedMotion::Frame> frame(Index object, Index k) const {
    return objects_[object]->motion->frame(frames_[k]);
  }
  /// Low and high corners of the boxes of nodes at a depth, and of leaves above it, relative to the center.
  Result<std::vector<float>> boxes(Index object, Index k, Index level) const;

 private:
  SceneData() = default;
  Result<void> add(Index object);

  std::vector<std::unique_ptr<Motion>> motions_;
  CheckSettings settings_;
  ReadOptions read_;
  bool cancels_ = true;  // a repair can be: requests are answered meanwhile
  std::vector<std::unique_ptr<PageObject>> objects_;
  std::vector<Index> frames_;
  Vec3 low_, high_;
};

}  // namespace foldproof
