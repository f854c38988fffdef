#pragma once
#include <cstddef>
#include <vector>

#include "peers/bounding_volume.hpp"
#include <oncollide/pipeline/forest.hpp>

namespace oncollide::tools {

/// The whole sphere-tree of one geometry, grown by the library's forest on the cpu backend as if tests had reached
/// every cell.
class GrownTree {
public:
    /// @param scene     one geometry; must outlive this
    /// @param settings  depth or max_error
    /// Throws Error{usage} when a level has more than `most` cells.
    GrownTree(const Scene& scene, const Settings& settings, std::size_t most = 1'000'000);

    int depth() const { return static_cast<int>(levels_.size()) - 1; }
    /// The cells of a level, 0 to depth(), that the surface enters.
    const std::vector<CellKey>& level(int l) const { return levels_[std::size_t(l)]; }
    std::vector<CoveringVolume> spheres(int level) const;
    const Ocst& tree() const { return *forest_.grown(GeometryId{0}); }
    /// No point of a sphere of that level is farther from the surface.
    double certified_reach(int level) const;
    std::size_t bytes() const { return forest_.bytes(); }

private:
    Forest forest_;
    std::vector<std::vector<CellKey>> levels_;
};

} // namespace oncollide::tools
