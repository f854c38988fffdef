#include "peers/contacts/contact_peer.hpp"

#include <array>
#include <map>

#include <ode/ode.h>

#include "peers/common/ode_mesh.hpp"

namespace oncollide::tools {
namespace {

class OdeContactPeer final : public ContactPeer {
public:
    explicit OdeContactPeer(std::span<const ContactPeerBody> bodies) : space_((start_ode(), dHashSpaceCreate(nullptr)))
    {
        dSpaceSetCleanup(space_, 0);
        for (const ContactPeerBody& body : bodies) {
            if (const auto* mesh = std::get_if<Mesh>(&body.geometry->data)) {
                auto& data = meshes_[body.geometry];
                if (!data) data = std::make_unique<OdeMeshData>(*mesh);
                geometries_.push_back(dCreateTriMesh(nullptr, data->id, nullptr, nullptr, nullptr));
            } else {
                const Eigen::Vector3d size = 2 * std::get<Box>(std::get<Shape>(body.geometry->data)).half;
                geometries_.push_back(dCreateBox(nullptr, size.x(), size.y(), size.z()));
            }
            dGeomSetCategoryBits(geometries_.back(), body.is_static ? 1 : 2);
            dGeomSetCollideBits(geometries_.back(), body.is_static ? 2 : 3);
            dSpaceAdd(space_, geometries_.back());
        }
    }
    ~OdeContactPeer() override
    {
        for (const dGeomID g : geometries_) dGeomDestroy(g);
        dSpaceDestroy(space_);
    }
    std::size_t contacts(std::span<const Eigen::Isometry3d> poses) override
    {
        for (std::size_t i = 0; i < poses.size(); ++i) place(geometries_[i], poses[i]);
        count_ = 0;
        dSpaceCollide(space_, this, take);
        return count_;
    }

private:
    static void take(void* data, dGeomID a, dGeomID b)
    {
        std::array<dContactGeom, 250> found; // as in DART
        static_cast<OdeContactPeer*>(data)->count_ +=
            static_cast<std::size_t>(dCollide(a, b, int(found.size()), found.data(), sizeof(dContactGeom)));
    }

    dSpaceID space_;
    std::map<const Geometry*, std::unique_ptr<OdeMeshData>> meshes_;
    std::vector<dGeomID> geometries_;
    std::size_t count_ = 0;
};

} // namespace

void add_contact_ode(std::vector<ContactContender>& all)
{
    all.push_back({.name = "ode",
                   .what = "ODE dCollide, at most 250 contacts a pair",
                   .promise = Promise::approximate,
                   .make = [](std::span<const ContactPeerBody> b) { return std::make_unique<OdeContactPeer>(b); }});
}

} // namespace oncollide::tools
