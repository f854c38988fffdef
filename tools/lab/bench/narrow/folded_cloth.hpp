#pragma once
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// A square cloth of about `triangles` triangles, side 1, laid in folds: it runs to and fro between bends, so that ten
/// layers lie above each other, and has ripples across the layers.
/// @param ripples  height of the ripples, as a share of the distance of two layers: layers stay apart below 0.3, and
///                 pass through each other from 0.6
Mesh make_folded_cloth(int triangles, double ripples);

} // namespace oncollide::tools
