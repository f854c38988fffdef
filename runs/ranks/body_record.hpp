#pragma once
#include <string>
#include <vector>

#include <oncollide/runs/ranks/bytes.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// The data of a body that a rank needs to decide its pairs.
struct BodyHere {
    std::uint32_t gid; ///< index in the whole scene
    std::uint32_t geometry;
    std::uint32_t layer, mask, group;
    bool is_static;
    Eigen::Isometry3d pose;
    std::vector<RigidMotion::Key> way{};   ///< the motion to `pose` from the pose in the last frame; empty: there is
                                           ///< none
    std::string name{};                    ///< as from csv_field if rows are written; else empty
    std::vector<std::uint32_t> excluded{}; ///< bodies that it never collides with
};

/// A body on its home rank, including its motion. Geometries are not sent: all ranks have the scene's.
struct BodyRecord : BodyHere {
    Eigen::Isometry3d start;
    Motion motion;
    Aabb box{}; ///< world AABB of the whole way, grown by half the clearance; empty: not yet known
};

void put_vector(Bytes& bytes, const Eigen::Vector3d& v);
void put_box(Bytes& bytes, const Aabb& box);
void put(Bytes& bytes, const BodyHere& body);
void put(Bytes& bytes, const BodyRecord& record);
BodyHere get_body(ByteReader& reader);
BodyRecord get_record(ByteReader& reader);

} // namespace oncollide
