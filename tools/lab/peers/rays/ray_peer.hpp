#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

#include "peers/common/contender.hpp"

// Contenders of the benchmark of rays. One file per library; each adds its contenders to the list.
namespace oncollide::tools {

/// Finds which segments meet a mesh.
class RayPeer {
public:
    virtual ~RayPeer() = default;
    /// Sets hit[i] to 1 if segments[i] meets the mesh, else to 0.
    virtual void trace(std::span<const Segment> segments, std::span<std::uint8_t> hit) = 0;
};

using RayContender = Contender<RayPeer, const Mesh&>;

using RayContenders = ContenderList<RayContender>;

/// The contenders of other libraries in this build.
RayContenders ray_contenders();

void add_ray_embree(std::vector<RayContender>& all);
void add_ray_bullet(std::vector<RayContender>& all);

} // namespace oncollide::tools
