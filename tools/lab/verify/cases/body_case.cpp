#include "verify/cases/body_case.hpp"

#include <initializer_list>

namespace oncollide::tools {

namespace {

std::vector<BodyCase> together(std::initializer_list<std::vector<BodyCase> (*)()> parts)
{
    std::vector<BodyCase> all;
    for (auto part : parts)
        for (BodyCase& c : part()) all.push_back(std::move(c));
    return all;
}

} // namespace

std::vector<BodyCase> surface_cases()
{
    return together({contact_cases, shape_cases, scale_cases});
}

std::vector<BodyCase> body_cases()
{
    return together({surface_cases, solid_cases});
}

Mesh mesh_of(std::vector<Eigen::Vector3d> vertices, std::vector<Triangle> triangles)
{
    return make_mesh("hard case", std::move(vertices), std::move(triangles));
}

Mesh mesh_of(const std::vector<Eigen::Vector3d>& corners)
{
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i + 2 < corners.size(); i += 3) triangles.push_back({i, i + 1, i + 2});
    return mesh_of(corners, std::move(triangles));
}

Mesh joined(const Mesh& a, const Mesh& b)
{
    Mesh sum = a;
    const auto first = std::uint32_t(a.vertices.size());
    sum.vertices.insert(sum.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const Triangle& t : b.triangles) sum.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    return mesh_of(std::move(sum.vertices), std::move(sum.triangles));
}

Mesh rotated(Mesh mesh, const Eigen::Matrix3d& turn, const Eigen::Vector3d& by)
{
    for (Eigen::Vector3d& v : mesh.vertices) v = turn * v + by;
    return mesh_of(std::move(mesh.vertices), std::move(mesh.triangles));
}

Mesh flipped(Mesh mesh)
{
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

Mesh shifted(const Mesh& mesh, const Eigen::Vector3d& by)
{
    return rotated(mesh, Eigen::Matrix3d::Identity(), by);
}

Eigen::Isometry3d at(double x, double y, double z)
{
    return at(Eigen::Vector3d(x, y, z), Eigen::Matrix3d::Identity());
}

Eigen::Isometry3d at(const Eigen::Vector3d& place, const Eigen::Matrix3d& turn)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = turn, pose.translation() = place;
    return pose;
}

Eigen::Matrix3d turn_by(double angle, const Eigen::Vector3d& axis)
{
    return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

Mesh scaled(const Mesh& mesh, double scale)
{
    return transformed("hard case", mesh, scale, Eigen::Vector3d::Zero());
}

} // namespace oncollide::tools
