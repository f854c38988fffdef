#pragma once
#include <memory>
#include <vector>

#include <oncollide/broadphase/support_map.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

namespace oncollide {

/// How far a cooked mesh reaches along directions: of its chunks only those are read that may hold the farthest point,
/// by the boxes around them in the top of the file.
class CookedSupport {
public:
    /// Throws ChunkFault where the file cannot be opened, or its top is no tree.
    CookedSupport(std::shared_ptr<const CookedMesh> mesh, const Eigen::Vector3d& centre);

    /// Reads what most() needs to be exact along a direction, of a length of about 1. Not beside
    /// other calls.
    void prepare(const Eigen::Vector3f& direction);
    /// What SupportMap::most() gives of all points, if it was prepared for and could be read; else that or more.
    float most(const Eigen::Vector3f& direction) const;
    std::size_t bytes() const;

private:
    /// Of a box along the axes around a chunk, relative to the centre.
    struct Box {
        Eigen::Vector3f centre = Eigen::Vector3f::Zero(), half = Eigen::Vector3f::Zero();
    };
    void add_boxes(const CookedMesh::Top& top);
    float bound(std::size_t chunk, const Eigen::Vector3f& direction) const;
    float most_of(std::size_t chunk, const Eigen::Vector3f& direction) const;
    bool read(std::size_t chunk);

    std::shared_ptr<const CookedMesh> mesh_;
    Eigen::Vector3d centre_;
    float rounding_; ///< of what is computed in float
    std::vector<Box> boxes_;
    std::vector<PointColumns> points_; ///< by chunk; empty: not read
    CookedMesh::Chunk read_;
};

} // namespace oncollide
