/// The meshes that are attacked.
#pragma once

#include <string>
#include <vector>

#include "foldproof/bvh.h"

namespace foldproof::search {

struct SearchMesh {
  std::string name;
  Topology topology;
  std::vector<double> positions;
};

/// Flat cloth, cylinder, bumpy sphere, crumpled sheet, hairpin of two sheets, a strip with a half turn,
/// slivers.
std::vector<SearchMesh> generated_meshes();
/// The first frame of real motions, as far as they are here.
std::vector<SearchMesh> real_meshes();

}  // namespace foldproof::search
