#include "peers/narrow/narrow_peer.hpp"

#include <algorithm>

#include <ode/ode.h>

namespace oncollide::tools {
namespace {

/// ODE must be initialised once per program, and closed at its end.
void start_ode()
{
    static const struct Library {
        Library() { dInitODE2(0); }
        ~Library() { dCloseODE(); }
    } library;
}

/// A mesh in ODE's form. ODE keeps pointers into these arrays.
class OdeMesh {
public:
    explicit OdeMesh(const Mesh& mesh) : data_(dGeomTriMeshDataCreate())
    {
        for (const Eigen::Vector3d& v : mesh.vertices) vertices_.insert(vertices_.end(), {v.x(), v.y(), v.z()});
        for (const Triangle& t : mesh.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
        dGeomTriMeshDataBuildDouble(data_, vertices_.data(), 3 * sizeof(double), int(mesh.vertices.size()),
                                    indices_.data(), int(indices_.size()), 3 * sizeof(dTriIndex));
        geometry = dCreateTriMesh(nullptr, data_, nullptr, nullptr, nullptr);
    }
    ~OdeMesh() { dGeomDestroy(geometry), dGeomTriMeshDataDestroy(data_); }
    OdeMesh(const OdeMesh&) = delete;
    OdeMesh& operator=(const OdeMesh&) = delete;

    dGeomID geometry;

private:
    dTriMeshDataID data_;
    std::vector<double> vertices_;
    std::vector<dTriIndex> indices_;
};

/// Collision queries only: ODE merges contacts before it returns them, so pairs of triangles are lost.
class OdeNarrowPeer final : public NarrowPeer {
public:
    OdeNarrowPeer(const Mesh& a, const Mesh& b) : a_((start_ode(), a)), b_(b) {}

    bool collides(const Eigen::Isometry3d& b) override
    {
        const Eigen::Vector3d& p = b.translation();
        dMatrix3 rotation{};
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column) rotation[4 * row + column] = b.linear()(row, column);
        dGeomSetPosition(b_.geometry, p.x(), p.y(), p.z());
        dGeomSetRotation(b_.geometry, rotation);
        dContactGeom contact;
        return dCollide(a_.geometry, b_.geometry, int(1u | CONTACTS_UNIMPORTANT), &contact, sizeof contact) > 0;
    }

private:
    OdeMesh a_, b_;
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
