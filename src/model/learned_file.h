/// The learned part of the model file.
#pragma once

#include "model/format.h"

namespace foldproof::inline internal {

flatbuffers::Offset<file::Learned> write_learned(flatbuffers::FlatBufferBuilder& builder,
                                                 const Learned& learned);

/// An upper bound of its size in a file.
std::uint64_t bound_of_learned_bytes(const Learned& learned);

/// Checks everything: sizes against each other and the mesh, numbers, indices. `poses`: size of Model::poses.
Result<std::shared_ptr<const Learned>> read_learned(const file::Learned& file, const Hierarchy& hierarchy,
                                                    std::size_t poses, const std::string& path);

}  // namespace foldproof::inline internal
