#pragma once
#include <memory>
#include <vector>

#include <oncollide/broadphase/bounds/support_map.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

namespace oncollide {

/// Support queries on a cooked mesh: reads only the chunks that may hold a support point, selected by the chunks' OBBs
/// in the top of the file.
class CookedSupport {
public:
    /// Throws ChunkFault if the file cannot be opened or its top is not a tree.
    CookedSupport(std::shared_ptr<const CookedMesh> mesh, const Eigen::Vector3d& centre);

    /// Reads the chunks that most() needs to be exact along `direction`, of length about 1. Not concurrently with any
    /// other call.
    void prepare(const Eigen::Vector3f& direction);
    /// The same as SupportMap::most() over all points, if the direction was prepared and its chunks could be read;
    /// otherwise an upper bound.
    float most(const Eigen::Vector3f& direction) const;
    std::size_t bytes() const;

private:
    /// AABB of a chunk, relative to the centre.
    struct Box {
        Eigen::Vector3f centre = Eigen::Vector3f::Zero(), half = Eigen::Vector3f::Zero();
    };
    void add_boxes(const CookedMesh::Top& top);
    float bound(std::size_t chunk, const Eigen::Vector3f& direction) const;
    float most_of(std::size_t chunk, const Eigen::Vector3f& direction) const;
    bool read(std::size_t chunk);

    std::shared_ptr<const CookedMesh> mesh_;
    Eigen::Vector3d centre_;
    float rounding_; ///< error bound of computations in float
    std::vector<Box> boxes_;
    std::vector<PointColumns> points_; ///< by chunk; empty: not read
    CookedMesh::Chunk read_;
};

} // namespace oncollide
