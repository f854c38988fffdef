#include "peers/peers.hpp"

#include <array>
#include <cstdarg>
#include <map>

#include <ode/ode.h>

namespace oncollide::tools {
namespace {

/// ODE must be initialised once per program, and closed at its end. It prints a message for each pair of meshes with
/// many contacts; these are dropped.
void start_ode()
{
    static const struct Library {
        Library()
        {
            dInitODE2(0), dSetMessageHandler([](int, const char*, va_list) {});
        }
        ~Library() { dCloseODE(); }
    } library;
}

/// A mesh in ODE's form. ODE keeps pointers into these arrays.
class OdeMeshData {
public:
    explicit OdeMeshData(const Mesh& mesh) : id(dGeomTriMeshDataCreate())
    {
        for (const Eigen::Vector3d& v : mesh.vertices) vertices_.insert(vertices_.end(), {v.x(), v.y(), v.z()});
        for (const Triangle& t : mesh.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
        dGeomTriMeshDataBuildDouble(id, vertices_.data(), 3 * sizeof(double), int(mesh.vertices.size()),
                                    indices_.data(), int(indices_.size()), 3 * sizeof(dTriIndex));
    }
    ~OdeMeshData() { dGeomTriMeshDataDestroy(id); }
    OdeMeshData(const OdeMeshData&) = delete;
    OdeMeshData& operator=(const OdeMeshData&) = delete;

    const dTriMeshDataID id;

private:
    std::vector<double> vertices_;
    std::vector<dTriIndex> indices_;
};

void place(dGeomID geometry, const Eigen::Isometry3d& pose)
{
    const Eigen::Vector3d& p = pose.translation();
    dMatrix3 rotation{};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) rotation[4 * row + column] = pose.linear()(row, column);
    dGeomSetPosition(geometry, p.x(), p.y(), p.z());
    dGeomSetRotation(geometry, rotation);
}

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

void add_ode(Contenders& all)
{
    all.narrow.all.push_back({.name = "ode",
                              .what = "ODE dCollide of two meshes, one contact",
                              .promise = Promise::approximate,
                              .least = 2,
                              .make = maker<OdeNarrowPeer>()});
    all.contacts.all.push_back({.name = "ode",
                                .what = "ODE dCollide, at most 250 contacts a pair",
                                .promise = Promise::approximate,
                                .make = maker<OdeContactPeer>()});
}

} // namespace oncollide::tools
