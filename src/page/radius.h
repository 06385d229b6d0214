/// How far mode sliders may go: certified radii, found when somebody asks.
#pragma once

#include <condition_variable>
#include <mutex>

#include "page/scene_data.h"

namespace foldproof {

class RadiusDesk {
 public:
  explicit RadiusDesk(const SceneData& scene) : scene_(scene), entries_(scene.objects().size()) {}

  /// What is known; the first to ask for an object orders it. Precondition: the object has modes.
  Json ask(Index object);
  /// Finds what was ordered, one after the other, until `stop` is set.
  void work(const std::atomic<bool>& stop);

 private:
  struct Entry {
    enum class State : std::uint8_t { Idle, Ordered, Done, Failed } state = State::Idle;
    double progress = 0, radius = 0, share = 0;
    std::size_t left_out = 0;
    std::string error = {};
  };
  Entry find(Index object, const std::atomic<bool>& stop);

  const SceneData& scene_;
  std::mutex mutex_;
  std::condition_variable ordered_;
  std::vector<Entry> entries_;
};

}  // namespace foldproof
