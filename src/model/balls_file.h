/// The balls in the model file.
#pragma once

#include "model/format.h"

namespace foldproof::inline internal {

/// Precondition: model.learned and model.balls.
flatbuffers::Offset<file::Balls> write_balls(flatbuffers::FlatBufferBuilder& builder, const Model& model);

/// An upper bound of their size in a file.
std::uint64_t bound_of_ball_bytes(const ReducedBalls& balls);

/// Null when another version of the proofs made them. Error: they are damaged, or not about this model, whose
/// other parts are read.
Result<std::shared_ptr<const ReducedBalls>> read_balls(const file::Balls& file, const Model& model,
                                                       const std::string& path);

}  // namespace foldproof::inline internal
