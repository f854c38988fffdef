#pragma once
#include <cstdarg>
#include <vector>

#include <Eigen/Geometry>
#include <ode/ode.h>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// ODE must be initialised once per program, and closed at its end. It prints a message for each pair of meshes with
/// many contacts; these are dropped.
inline void start_ode()
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

inline void place(dGeomID geometry, const Eigen::Isometry3d& pose)
{
    const Eigen::Vector3d& p = pose.translation();
    dMatrix3 rotation{};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) rotation[4 * row + column] = pose.linear()(row, column);
    dGeomSetPosition(geometry, p.x(), p.y(), p.z());
    dGeomSetRotation(geometry, rotation);
}

} // namespace oncollide::tools
