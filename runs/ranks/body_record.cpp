#include <oncollide/runs/ranks/body_record.hpp>

namespace oncollide {

void put_vector(Bytes& bytes, const Eigen::Vector3d& v)
{
    for (int k = 0; k < 3; ++k) put(bytes, v[k]);
}
void put_box(Bytes& bytes, const Aabb& box)
{
    put_vector(bytes, box.min), put_vector(bytes, box.max);
}

namespace {

void put_pose(Bytes& bytes, const Eigen::Isometry3d& pose)
{
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column) put(bytes, pose.matrix()(row, column));
}
Eigen::Isometry3d get_pose(ByteReader& reader)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column) pose.matrix()(row, column) = reader.get<double>();
    return pose;
}

Eigen::Vector3d get_vector(ByteReader& reader)
{
    Eigen::Vector3d v;
    for (int k = 0; k < 3; ++k) v[k] = reader.get<double>();
    return v;
}

Aabb get_box(ByteReader& reader)
{
    Aabb box;
    box.min = get_vector(reader), box.max = get_vector(reader);
    return box;
}

void put_motion(Bytes& bytes, const Motion& motion)
{
    put(bytes, static_cast<std::uint32_t>(motion.index()));
    if (const auto* keyed = std::get_if<Keyed>(&motion)) {
        put(bytes, static_cast<std::uint32_t>(keyed->keys.size()));
        for (const Keyed::Key& key : keyed->keys) {
            put(bytes, key.time), put_vector(bytes, key.position);
            for (int k = 0; k < 4; ++k) put(bytes, key.rotation.coeffs()[k]);
        }
    } else if (const auto* drift = std::get_if<Drift>(&motion)) {
        put_vector(bytes, drift->velocity), put_vector(bytes, drift->spin), put_box(bytes, drift->walls);
    } else if (const auto* jitter = std::get_if<Jitter>(&motion)) {
        put(bytes, jitter->step), put(bytes, jitter->seed), put(bytes, jitter->index);
        put_box(bytes, jitter->walls);
    }
}
Motion get_motion(ByteReader& reader)
{
    static_assert(std::variant_size_v<Motion> == 4, "write and read the new motion, too");
    switch (reader.get<std::uint32_t>()) {
    case 1: {
        Keyed keyed;
        keyed.keys.resize(reader.get<std::uint32_t>());
        for (Keyed::Key& key : keyed.keys) {
            key.time = reader.get<double>(), key.position = get_vector(reader);
            for (int k = 0; k < 4; ++k) key.rotation.coeffs()[k] = reader.get<double>();
        }
        return keyed;
    }
    case 2: {
        Drift drift;
        drift.velocity = get_vector(reader), drift.spin = get_vector(reader), drift.walls = get_box(reader);
        return drift;
    }
    case 3: {
        Jitter jitter;
        jitter.step = reader.get<double>(), jitter.seed = reader.get<std::uint64_t>();
        jitter.index = reader.get<std::uint64_t>(), jitter.walls = get_box(reader);
        return jitter;
    }
    default:
        return Still{};
    }
}

} // namespace

namespace {

// A body without a way needs no bytes for it; checkpoints depend on the checksums of records.
constexpr std::uint8_t static_bit = 1, way_bit = 2;

} // namespace

void put(Bytes& bytes, const BodyHere& b)
{
    for (const std::uint32_t number : {b.gid, b.geometry, b.layer, b.mask, b.group}) put(bytes, number);
    put(bytes, static_cast<std::uint8_t>((b.is_static ? static_bit : 0) | (b.way.empty() ? 0 : way_bit)));
    put_pose(bytes, b.pose), put_list(bytes, b.name), put_list(bytes, b.excluded);
    if (b.way.empty()) return;
    put(bytes, static_cast<std::uint32_t>(b.way.size()));
    for (const RigidMotion::Key& key : b.way) put(bytes, key.time), put_pose(bytes, key.pose);
}

void put(Bytes& bytes, const BodyRecord& r)
{
    put(bytes, static_cast<const BodyHere&>(r));
    put_pose(bytes, r.start), put_motion(bytes, r.motion), put_box(bytes, r.box);
}

BodyHere get_body(ByteReader& reader)
{
    BodyHere b{};
    for (std::uint32_t* number : {&b.gid, &b.geometry, &b.layer, &b.mask, &b.group})
        *number = reader.get<std::uint32_t>();
    const auto bits = reader.get<std::uint8_t>();
    b.is_static = (bits & static_bit) != 0, b.pose = get_pose(reader);
    b.name = reader.get_list<std::string>(), b.excluded = reader.get_list<std::vector<std::uint32_t>>();
    if (bits & way_bit) b.way.resize(reader.get<std::uint32_t>());
    for (RigidMotion::Key& key : b.way) key.time = reader.get<double>(), key.pose = get_pose(reader);
    return b;
}

BodyRecord get_record(ByteReader& reader)
{
    BodyRecord r{get_body(reader), {}, {}};
    r.start = get_pose(reader), r.motion = get_motion(reader), r.box = get_box(reader);
    return r;
}

} // namespace oncollide
