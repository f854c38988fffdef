#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// Two bodies that are hard to answer for: a stands still, b takes one pose after the other.
struct BodyCase {
    std::string family, name;
    Mesh a, b;
    Eigen::Isometry3d pose_a = Eigen::Isometry3d::Identity();
    std::vector<Eigen::Isometry3d> poses_b{Eigen::Isometry3d::Identity()};
    /// By construction, at every pose; where it is known without computing, to check the truth itself by.
    std::optional<bool> collide{};
    std::optional<bool> solids_collide{}; ///< the same as solids
};

/// The hard cases of every family, in the order to show them: of surfaces, then solid_cases().
std::vector<BodyCase> body_cases();
std::vector<BodyCase> surface_cases();

/// Erleben's degenerate configurations, the positions at both ends of each query: a corner and a face, or two edges, as
/// meshes of one triangle (without area where that is all they are). Empty when `data` holds no queries/.
/// Throws Error{bad_data} naming file and line.
std::vector<BodyCase> query_cases(const std::filesystem::path& data);

// The parts of surface_cases(); and what is hard for solids alone.
std::vector<BodyCase> contact_cases(); ///< boxes, walls, twins, plates
std::vector<BodyCase> shape_cases();   ///< slivers, needles, triangles without area, open meshes, lone triangles
std::vector<BodyCase> scale_cases();   ///< one inside another, scales, offsets, sizes far apart, grazing motion
std::vector<BodyCase> solid_cases();   ///< enclosed, cavities, several parts, grains just inside, the same of all sizes

// What the parts are made from.
Mesh mesh_of(std::vector<Eigen::Vector3d> vertices, std::vector<Triangle> triangles);
/// Triangles between each three points.
Mesh mesh_of(const std::vector<Eigen::Vector3d>& corners);
Mesh joined(const Mesh& a, const Mesh& b);
Mesh rotated(Mesh mesh, const Eigen::Matrix3d& turn, const Eigen::Vector3d& by);
Eigen::Isometry3d at(double x, double y, double z);
Eigen::Isometry3d at(const Eigen::Vector3d& place, const Eigen::Matrix3d& turn);
/// By an angle about an axis.
Eigen::Matrix3d turn_by(double angle, const Eigen::Vector3d& axis);

/// About the origin.
Mesh scaled(const Mesh& mesh, double scale);

} // namespace oncollide::tools
