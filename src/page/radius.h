/// Certified radii of mode sliders, computed on request.
#pragma once

#include <condition_variable>
#include <mutex>

#include "page/scene_data.h"

namespace foldproof {

class RadiusService {
 public:
  explicit RadiusService(const SceneData& scene) : scene_(scene), entries_(scene.objects().size()) {}

  /// The state of an object's radius. The first request queues its computation. Precondition: the object has
  /// modes.
  Json request(Index object);
  /// Computes a queued radius; false if there is none.
  bool compute_queued(const std::atomic<bool>& stop);
  /// Waits until a radius is queued, but not for long.
  void wait();

 private:
  struct Entry {
    enum class State : std::uint8_t { Idle, Queued, Done, Failed } state = State::Idle;
    double progress = 0, radius = 0, share = 0;
    std::size_t uncertified = 0;
    std::vector<Index> uncertified_triangles = {};  // of these pairs, ascending
    std::string error = {};
  };
  Entry compute(Index object, const std::atomic<bool>& stop);

  const SceneData& scene_;
  std::mutex mutex_;
  std::condition_variable queued_;
  std::vector<Entry> entries_;
};

}  // namespace foldproof
