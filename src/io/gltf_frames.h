/// The times of frames, and which keys of an animation they show.
#pragma once

#include "io/gltf_scene.h"

namespace foldproof::io {

/// Frames at k / fps seconds up to the last key, which is the last frame.
class GltfFrames {
 public:
  /// `duration`: time of the last key, seconds. `fps` > 0.
  GltfFrames(double fps, double duration);

  /// A whole number, or infinite.
  double count() const { return last_ + 1; }
  /// Of frame `k` < count(), seconds.
  double time(double k) const { return k == last_ ? duration_ : k / fps_; }
  /// Whether a frame takes a key at this time.
  bool shows(double key) const;

 private:
  double fps_, duration_;
  double last_;  // the number of the last frame
};

/// Whether a frame at a time shows a key: they differ by no more than rounding to float does.
bool is_time_of_key(double time, double key);

/// What a user needs to know about keys that lie between frames, of which there are at most `max_frames`;
/// empty where none do.
std::string note_on_keys(const GltfScene& scene, double fps, double max_frames);

}  // namespace foldproof::io
