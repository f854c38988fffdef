#include <oncollide/scenes/files/assembly/part_placer.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/scenes/files/assembly/node_paths.hpp>

namespace oncollide {

bool PartPlacer::place(std::uint32_t node, std::uint32_t mesh, const Eigen::Affine3d& pose)
{
    constexpr double farthest = 1e15; // metres
    if (!(pose.matrix().cwiseAbs().maxCoeff() <= farthest)) return false;
    const auto [number, rotation] = shared(mesh, pose.linear());
    Eigen::Isometry3d rigid = Eigen::Isometry3d::Identity();
    rigid.linear() = rotation, rigid.translation() = pose.translation();
    parts_.push_back({.node = node, .mesh = number, .pose = rigid});
    return true;
}

/// The index in placed_ that a part shares with other parts of its mesh, and the part's rotation relative to it. World
/// accepts poses that are rigid to 1e-6; a file's floats are accurate to about 1e-7.
std::pair<std::uint32_t, Eigen::Matrix3d> PartPlacer::shared(std::uint32_t mesh, const Eigen::Matrix3d& linear)
{
    const Eigen::Matrix3d same = Eigen::Matrix3d::Identity();
    const auto is_rotation = [&](const Eigen::Matrix3d& m) {
        return (m.transpose() * m - same).cwiseAbs().maxCoeff() < 5e-7 && m.determinant() > 0;
    };
    if (by_mesh_.size() <= mesh) by_mesh_.resize(mesh + std::size_t{1});
    std::vector<std::uint32_t>& of_mesh = by_mesh_[mesh];
    constexpr std::size_t most = 64; // entries compared: a file may scale each part differently
    for (std::size_t k = 0; k < std::min(of_mesh.size(), most); ++k) {
        const Eigen::Matrix3d rotated = linear * placed_[of_mesh[k]].inverse;
        if (!(std::abs(rotated.col(0).squaredNorm() - 1) < 1e-6)) continue; // nearly all end here
        if (rotated.allFinite() && is_rotation(rotated))
            return {of_mesh[k], linear == placed_[of_mesh[k]].linear ? same : rotated};
    }
    const bool rigid = is_rotation(linear);
    of_mesh.push_back(static_cast<std::uint32_t>(placed_.size()));
    placed_.push_back({mesh, rigid ? same : linear, rigid ? same : linear.inverse()});
    return {of_mesh.back(), rigid ? linear : same};
}

RawAssembly PartPlacer::take(std::span<const std::uint32_t> above,
                             const std::function<std::string_view(std::uint32_t)>& name_of, const AddMesh& add,
                             int threads)
{
    const NodePaths paths(above, name_of, parts_.size());
    RawAssembly assembly{std::vector<RawMesh>(placed_.size()), std::move(parts_)};
    for (RawPart& part : assembly.parts) {
        part.name = paths.name(part.node), part.path = paths.path(part.node);
        part.above = above[part.node];
    }
    parallel_chunks(placed_.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            WeldedMesh mesh;
            add(placed_[i].mesh, Eigen::Affine3d(placed_[i].linear), mesh);
            assembly.meshes[i] = mesh.take();
        }
    });
    return assembly;
}

} // namespace oncollide
