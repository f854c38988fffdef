#pragma once
#include <compare>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/scene.hpp>

#include "peers/common/contender.hpp"

// Contenders of the narrow phase benchmark. One file per library; each adds its contenders to the list.
namespace oncollide::tools {

/// Triangle `a` of the first mesh and triangle `b` of the second.
struct TrianglePair {
    std::uint32_t a, b;

    auto operator<=>(const TrianglePair&) const = default;
};

/// A method for queries of two meshes, of which the second moves. All distances in metres.
class NarrowPeer {
public:
    virtual ~NarrowPeer() = default;
    /// True if the surfaces meet. Conservative methods also return true if they are uncertain.
    virtual bool collides(const Eigen::Isometry3d& b) = 0;
    /// Finds all pairs of triangles that meet, each once, in any order; overwrites `pairs`.
    virtual void all_pairs(const Eigen::Isometry3d&, std::vector<TrianglePair>& pairs) { pairs.clear(); }
    /// Distance of the surfaces, 0 if they meet.
    virtual double distance(const Eigen::Isometry3d&) { return 0; }
    /// Figures of its data and its queries so far, in words; empty: none.
    virtual std::string figures() const { return {}; }
};

using NarrowContender = Contender<NarrowPeer, const Mesh&, const Mesh&>;

using NarrowContenders = ContenderList<NarrowContender>;

NarrowContenders narrow_contenders();

/// Sphere-trees of this depth, and FCL for poses that are left over, if requested.
NarrowContender sphere_walk(int depth, bool then_fcl);
void add_narrow_oncollide(std::vector<NarrowContender>& all);
void add_narrow_fcl(std::vector<NarrowContender>& all);
void add_narrow_embree(std::vector<NarrowContender>& all);
void add_narrow_bullet(std::vector<NarrowContender>& all);
void add_narrow_ode(std::vector<NarrowContender>& all);
void add_narrow_cgal(std::vector<NarrowContender>& all);

} // namespace oncollide::tools
