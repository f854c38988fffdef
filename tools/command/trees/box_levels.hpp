#pragma once
#include <cstddef>
#include <vector>

#include "trees/bounding_volume.hpp"
#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide::tools {

/// The OBBs of a tree by level, in the mesh's frame, as tests read them. Level l holds the nodes l steps below the
/// root, and the single-triangle nodes above them, so each level covers the whole surface. Ends with the level on which
/// every triangle has its own OBB, or before the first level of more than `most` OBBs. Grows the tree as needed.
std::vector<std::vector<CoveringVolume>> box_levels(ObbTree& tree, std::size_t most = 1'000'000);

} // namespace oncollide::tools
