#pragma once
#include <string>
#include <vector>

#include <oncollide/pipeline/ranks/bytes.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// What every rank must know of a body that it looks at: all that a pair's verdict depends on.
struct BodyHere {
    std::uint32_t gid; ///< its index in the whole scene
    std::uint32_t geometry;
    std::uint32_t layer, mask, group;
    bool is_static;
    Eigen::Isometry3d pose;
    std::string name{};                    ///< as csv_field gives it, where rows are to be written; else empty
    std::vector<std::uint32_t> excluded{}; ///< bodies that it never collides with
};

/// A body as its home rank has it: how it moves, too. Its geometry stays where it is: all ranks know the scene's.
struct BodyRecord : BodyHere {
    Eigen::Isometry3d start;
    Motion motion;
    Aabb box{}; ///< world; empty: not known yet. Grown by half the clearance
};

void put_vector(Bytes& bytes, const Eigen::Vector3d& v);
void put_box(Bytes& bytes, const Aabb& box);
void put(Bytes& bytes, const BodyHere& body);
void put(Bytes& bytes, const BodyRecord& record);
BodyHere get_body(ByteReader& reader);
BodyRecord get_record(ByteReader& reader);

} // namespace oncollide
