#pragma once
#include <cstddef>
#include <vector>

#include "peers/bounding_volume.hpp"
#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide::tools {

/// The oriented boxes of a tree by levels, in the mesh's frame, as tests read them. Level l holds those l nodes below
/// the root, and those of one triangle above: so each level stands for the whole surface. Ends with the level on which
/// every triangle has its own box, or before the first of more than `most`. Grows the tree so far.
std::vector<std::vector<CoveringVolume>> box_levels(ObbTree& tree, std::size_t most = 1'000'000);

} // namespace oncollide::tools
