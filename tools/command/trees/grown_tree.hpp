#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "trees/bounding_volume.hpp"
#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide::tools {

/// False for half-spaces, which are unbounded, and for terrains, which are searched by their own grid.
bool has_spheres(const GeometryData& data);

/// The sphere-tree of a geometry, grown by the library's model store on the cpu backend as if tests had reached every
/// cell.
class GrownTree {
public:
    /// @param settings  depth or max_error, and threads
    /// @param levels    grow only this many levels below the root; nullopt: all
    /// Precondition: has_spheres(). Throws Error{usage} if a level has more than `most` cells.
    GrownTree(std::shared_ptr<const Geometry> geometry, const Settings& settings, std::optional<int> levels = {},
              std::size_t most = 1'000'000);

    GrownTree(const GrownTree&) = delete;

    int depth() const { return static_cast<int>(levels_.size()) - 1; } ///< depth of the grown part
    /// The cells of a level, 0 to depth(), that the surface intersects.
    const std::vector<CellKey>& level(int l) const { return levels_[std::size_t(l)]; }
    std::vector<CoveringVolume> spheres(int level) const;
    const Ocst& tree() const { return *model_.spheres(); }
    /// Largest distance of a point of a sphere of that level from the surface.
    double certified_reach(int level) const;
    std::size_t bytes() const { return models_.bytes(); }

private:
    Settings settings_;
    ModelStore models_;
    Model& model_;
    std::vector<std::vector<CellKey>> levels_;
};

/// The trees of a scene's geometries, all of the same depth, each grown on first use, and again after a mesh deforms.
class GrownTrees {
public:
    /// The scene must outlive it.
    GrownTrees(const Scene& scene, int depth, int threads) : scene_(scene), depth_(depth), threads_(threads) {}
    /// Throws Error{usage} if the tree would have too many cells.
    const GrownTree& operator[](GeometryId geometry);

private:
    const Scene& scene_;
    int depth_, threads_;
    GeometryList geometries_; ///< of the trees
    std::vector<std::unique_ptr<GrownTree>> trees_;
};

} // namespace oncollide::tools
