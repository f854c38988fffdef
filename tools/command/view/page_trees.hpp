#pragma once
#include <cstddef>
#include <memory>
#include <vector>

#include <oncollide/scenes/scene.hpp>

#include "trees/bounding_volume.hpp"

namespace oncollide::tools {

/// The upper levels of a geometry's trees, in its own frame, fully grown.
struct PageTrees {
    struct Level {
        std::vector<CoveringVolume> volumes;
        double error; ///< largest distance of a volume's points from the surface, metres
    };
    std::vector<Level> spheres, boxes; ///< boxes: only for meshes

    std::size_t bytes() const; ///< bytes on a page
};

/// Levels of at most `most` volumes each.
PageTrees make_page_trees(std::shared_ptr<const Geometry> geometry, std::size_t most, int threads);

} // namespace oncollide::tools
