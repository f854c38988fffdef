#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::tools {

/// Two bodies that are hard to decide: a is static, b takes one pose after the other.
struct BodyCase {
    std::string family, name;
    Mesh a, b;
    Eigen::Isometry3d pose_a = Eigen::Isometry3d::Identity();
    std::vector<Eigen::Isometry3d> poses_b{Eigen::Isometry3d::Identity()};
    /// Whether the surfaces collide at every pose, where this is known by construction. Checks the truth itself.
    std::optional<bool> collide{};
    std::optional<bool> solids_collide{}; ///< the same for solids
};

/// The hard cases of all families, in the order of the rows: surface_cases(), then solid_cases().
std::vector<BodyCase> body_cases();
std::vector<BodyCase> surface_cases();

/// Erleben's degenerate configurations, with the positions at both ends of each query: a vertex and a face, or two
/// edges, as meshes of one triangle (a degenerate one if need be). Empty if `data` has no folder queries/.
/// Throws Error{bad_data} naming file and line.
std::vector<BodyCase> query_cases(const std::filesystem::path& data);

// The parts of surface_cases(), and the cases that are hard only for solids.
std::vector<BodyCase> contact_cases(); ///< boxes, walls, twins, plates
std::vector<BodyCase> shape_cases();   ///< slivers, needles, triangles without area, open meshes, lone triangles
std::vector<BodyCase> scale_cases();   ///< one inside another, scales, offsets, very different sizes, grazing motion
std::vector<BodyCase> solid_cases();   ///< enclosed, cavities, several parts, grains just inside, in all sizes

// Functions to make parts.
Mesh mesh_of(std::vector<Eigen::Vector3d> vertices, std::vector<Triangle> triangles);
/// One triangle for every three points.
Mesh mesh_of(const std::vector<Eigen::Vector3d>& corners);
Mesh joined(const Mesh& a, const Mesh& b);
Mesh rotated(Mesh mesh, const Eigen::Matrix3d& turn, const Eigen::Vector3d& by);
Mesh flipped(Mesh mesh); ///< inside out
Mesh shifted(const Mesh& mesh, const Eigen::Vector3d& by);
Eigen::Isometry3d at(double x, double y, double z);
Eigen::Isometry3d at(const Eigen::Vector3d& place, const Eigen::Matrix3d& turn);
/// Rotation by an angle about an axis.
Eigen::Matrix3d turn_by(double angle, const Eigen::Vector3d& axis);

/// Scaled about the origin.
Mesh scaled(const Mesh& mesh, double scale);

/// Adds cases of a family; a is at the origin.
struct CaseFamily {
    std::vector<BodyCase>& cases;
    std::string name, prefix{}; ///< of the cases' names

    void operator()(const std::string& what, const Mesh& a, const Mesh& b, const Eigen::Isometry3d& pose,
                    std::optional<bool> collide = {}) const
    {
        cases.push_back({name, prefix + what, a, b, Eigen::Isometry3d::Identity(), {pose}, collide});
    }
};

} // namespace oncollide::tools
