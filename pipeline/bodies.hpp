#pragma once
#include <cstdint>
#include <span>

#include <Eigen/Geometry>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/scenes/rigid_motion.hpp>

namespace oncollide {

struct WorldImpl;

/// A new body, for Bodies::add().
struct BodySpec {
    ModelId model{};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< rigid: body frame to world, metres
    bool is_static = false;           ///< two static bodies never form a pair; a static body may still be moved
    std::uint32_t layer = 1;          ///< bits: the layers that the body is on
    std::uint32_t mask = 0xffffffffu; ///< bits: the layers that the body collides with
    std::uint32_t group = 0;          ///< no two bodies of one group other than 0 form a pair. To keep only neighbours
                                      ///< apart, as the links of a robot, use Bodies::exclude()
    std::uint64_t user = 0;           ///< yours: the World stores it and does not read it
};

/// The part of a BodySpec that decides which bodies form pairs. Limits a query to the bodies that would form a pair
/// with such a body.
struct CollisionFilter {
    std::uint32_t layer = 1, mask = 0xffffffffu, group = 0;
    friend bool operator==(const CollisionFilter&, const CollisionFilter&) = default;
};

/// One body or many, for calls that change bodies.
class BodySpan : public std::span<const BodyId> {
public:
    BodySpan(const BodyId& body) : std::span<const BodyId>(&body, 1) {} ///< `body` must outlive the call
    template <class Range>
    requires std::is_convertible_v<const Range&, std::span<const BodyId>> BodySpan(const Range& bodies)
        : std::span<const BodyId>(bodies)
    {
    }
};

/// The bodies of a World. World::bodies() returns them. Errors, threads and ids as World's.
class ONCOLLIDE_API Bodies {
public:
    Bodies(const Bodies&) = delete;
    Bodies& operator=(const Bodies&) = delete;

    /// In solid mode Error{bad_data} names a mesh that is not closed, and its open edges, at its first body.
    BodyId add(const BodySpec& body);
    void add(std::span<const BodySpec> bodies, std::span<BodyId> ids);
    void reserve(std::size_t bodies); ///< makes room for this number of bodies in all
    void remove(BodySpan bodies);     ///< lists each body once

    bool contains(BodyId body) const;
    std::size_t size() const; ///< number of bodies
    /// The body in a slot; null if the slot is free. Slots are less than the greatest number of bodies so far.
    BodyId at(std::uint32_t slot) const;

    const Eigen::Isometry3d& pose(BodyId body) const; ///< valid until the next change
    void set_pose(BodyId body, const Eigen::Isometry3d& pose);
    void set_pose(std::span<const BodyId> bodies, std::span<const Eigen::Isometry3d> poses);
    /// Moves the body as set_pose() does, and lets the next step() report contacts on the way: from its pose so far to
    /// `to`, over the time from 0 to 1. The motion ends with that step. Until then queries may test a larger box than
    /// the body's.
    void set_motion(BodyId body, const Eigen::Isometry3d& to, MotionPath path = MotionPath::linear);
    void set_motion(std::span<const BodyId> bodies, std::span<const Eigen::Isometry3d> to,
                    MotionPath path = MotionPath::linear);
    /// The same along any motion; the body need not be at its first pose.
    void set_motion(BodyId body, const RigidMotion& motion);

    bool is_static(BodyId body) const;
    void set_static(BodySpan bodies, bool is_static);
    /// Puts bodies to sleep. While the two bodies of a pair are each asleep or static, the pair stays as it is: it is
    /// reported with its last result, begins and ends nothing, and is not tested. A budget lets other pairs at rest be
    /// tested in every frame; pairs of sleeping bodies are tested only while undecided. A change of its pose, filter or
    /// model wakes a body.
    void sleep(BodySpan bodies);
    void wake(BodySpan bodies);
    bool is_asleep(BodyId body) const;

    CollisionFilter filter(BodyId body) const;
    void set_filter(BodySpan bodies, const CollisionFilter& filter);
    /// The two never form a pair, until include() or until one of them is removed.
    void exclude(BodyId a, BodyId b);
    void include(BodyId a, BodyId b);
    bool excluded(BodyId a, BodyId b) const;

    ModelId model(BodyId body) const;
    void set_model(BodySpan bodies, ModelId model);
    std::uint64_t user(BodyId body) const;
    void set_user(BodyId body, std::uint64_t user);

private:
    friend struct WorldImpl;
    explicit Bodies(WorldImpl& world) : world_(&world) {}
    WorldImpl* world_;
};

} // namespace oncollide
