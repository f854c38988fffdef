#pragma once
#include <compare>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>
#include <oncollide/scenes/scene.hpp>

#include "peers/peer.hpp"

// Who takes part in the benchmark of the narrow phase. One file a library; each adds what it has to the list.
namespace oncollide::tools {

/// Triangle `a` of the first mesh and triangle `b` of the second.
struct TrianglePair {
    std::uint32_t a, b;

    auto operator<=>(const TrianglePair&) const = default;
};

/// One way to answer for two meshes, of which the second is moved. All distances in metres.
class NarrowPeer {
public:
    virtual ~NarrowPeer() = default;
    /// Do the surfaces meet? One that is only conservative says yes when it is not sure.
    virtual bool collides(const Eigen::Isometry3d& b) = 0;
    /// Every two triangles that meet, each once, in any order; `pairs` is overwritten.
    virtual void all_pairs(const Eigen::Isometry3d&, std::vector<TrianglePair>& pairs) { pairs.clear(); }
    /// Of the surfaces, 0 when they meet.
    virtual double distance(const Eigen::Isometry3d&) { return 0; }
};

struct NarrowContender {
    std::string name; ///< as in --only
    std::string what; ///< library and structure
    Contender::Group group = Contender::Group::debian;
    /// What its answers promise. Conservative: no collision is missed, but some are false. Approximate: nothing, its
    /// errors are only counted.
    enum class Promise { exact, conservative, approximate } promise = Promise::exact;
    bool has_all_pairs = false, has_distance = false; ///< beside collides()
    std::size_t least = 1;                            ///< triangles a mesh must have, or it crashes
    /// Builds what it keeps between queries.
    std::function<std::unique_ptr<NarrowPeer>(const Mesh& a, const Mesh& b)> make;
};

using NarrowContenders = ContenderList<NarrowContender>;

NarrowContenders narrow_contenders();

void add_narrow_oncollide(std::vector<NarrowContender>& all);
void add_narrow_fcl(std::vector<NarrowContender>& all);
void add_narrow_embree(std::vector<NarrowContender>& all);
void add_narrow_bullet(std::vector<NarrowContender>& all);
void add_narrow_ode(std::vector<NarrowContender>& all);
void add_narrow_cgal(std::vector<NarrowContender>& all);

} // namespace oncollide::tools
