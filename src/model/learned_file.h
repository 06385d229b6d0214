/// The learned part of the model file.
#pragma once

#include "model/format.h"

namespace foldproof {

flatbuffers::Offset<file::Learned> write_learned(flatbuffers::FlatBufferBuilder& builder,
                                                 const Learned& learned);

/// What it takes in a file, a little more rather than less.
std::uint64_t bound_of_learned_bytes(const Learned& learned);

/// Everything is checked: sizes against each other and the mesh, numbers, indices. `poses`: of the model.
Result<std::shared_ptr<const Learned>> read_learned(const file::Learned& file, const Hierarchy& hierarchy,
                                                    std::size_t poses, const std::string& path);

}  // namespace foldproof
