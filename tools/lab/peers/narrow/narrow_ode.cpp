#include "peers/narrow/narrow_peer.hpp"

#include <algorithm>

#include "peers/common/ode_mesh.hpp"

namespace oncollide::tools {
namespace {

/// Collision queries only: ODE merges contacts before it returns them, so pairs of triangles are lost.
class OdeNarrowPeer final : public NarrowPeer {
public:
    OdeNarrowPeer(const Mesh& a, const Mesh& b)
        : data_a_((start_ode(), a)), data_b_(b), a_(dCreateTriMesh(nullptr, data_a_.id, nullptr, nullptr, nullptr)),
          b_(dCreateTriMesh(nullptr, data_b_.id, nullptr, nullptr, nullptr))
    {
    }
    ~OdeNarrowPeer() override { dGeomDestroy(a_), dGeomDestroy(b_); }

    bool collides(const Eigen::Isometry3d& b) override
    {
        place(b_, b);
        dContactGeom contact;
        return dCollide(a_, b_, int(1u | CONTACTS_UNIMPORTANT), &contact, sizeof contact) > 0;
    }

private:
    OdeMeshData data_a_, data_b_;
    dGeomID a_, b_;
};

} // namespace

void add_narrow_ode(std::vector<NarrowContender>& all)
{
    all.push_back({.name = "ode",
                   .what = "ODE dCollide of two meshes, one contact",
                   .promise = Promise::approximate,
                   .least = 2,
                   .make = [](const Mesh& a, const Mesh& b) { return std::make_unique<OdeNarrowPeer>(a, b); }});
}

} // namespace oncollide::tools
