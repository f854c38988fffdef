#pragma once
#include <bit>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include <oncollide/pipeline/world/placed_tests.hpp>
#include <oncollide/robots/copied_bodies.hpp>

namespace oncollide {

/// The middles of the groups in some configurations, relative to the first link.
struct GroupCentres {
    Eigen::Vector3d origin = Eigen::Vector3d::Zero(); ///< origin of that link, in the first configuration
    std::uint32_t count = 0, stride = 0;              ///< configurations; rounded up to a multiple of 8
    std::vector<float> x, y, z;                       ///< by group, then by configuration
    std::vector<Aabb> boxes;                          ///< by group: the box around all of its middles, in the world
    std::vector<double> sizes;                        ///< by group: upper bound on the sum of a middle's coordinates

    /// @param poses  the poses of all links, by configuration
    void place(std::span<const GroupCover> groups, std::span<const Eigen::Isometry3d> poses, std::size_t links);
    BallColumns of(std::size_t group) const
    {
        return {&x[group * stride], &y[group * stride], &z[group * stride], nullptr};
    }
};

/// Calls visit(i) for each bit i that is set.
template <class Visit>
void each_bit(std::span<const std::uint8_t> bits, Visit visit)
{
    for (std::uint32_t k = 0; k < bits.size(); ++k)
        for (unsigned b = bits[k]; b; b &= b - 1) visit(8 * k + static_cast<std::uint32_t>(std::countr_zero(b)));
}

/// Bodies of a World, numbered in the order in which they were needed first.
class PlacedBodies {
public:
    explicit PlacedBodies(const WorldAccess::PlacedTests& tests) : tests_(tests) {}

    void clear() { bodies_.clear(), numbers_.clear(); }
    std::uint32_t number_of(std::uint32_t slot);
    const PlacedBody& operator[](std::uint32_t number) const { return bodies_[number]; }

private:
    const WorldAccess::PlacedTests& tests_;
    std::vector<PlacedBody> bodies_;
    std::unordered_map<std::uint32_t, std::uint32_t> numbers_; ///< by slot
};

/// Finds the bodies of a World that are near groups of a robot.
class Surroundings {
public:
    struct Near {
        std::uint32_t configuration, body; ///< for body()
    };

    Surroundings(std::span<const GroupCover> groups, WorldAccess::PlacedTests& tests)
        : groups_(groups), tests_(tests), bodies_(tests)
    {
    }

    /// @param own     sorted slots of bodies that do not count
    /// @param copied  bodies that have other poses in each configuration, or null. Keeps a reference.
    void begin(const CollisionFilter& filter, std::vector<std::uint32_t> own, const CopiedBodies* copied);

    /// Finds the bodies that may be near in any configuration. Keeps references.
    /// @param first  the number of the first configuration
    void prepare(const GroupCentres& centres, const NearParts& near, std::size_t first);
    /// The bodies near the group in the configurations of these bits; by configurations. Valid until the next call.
    std::span<const Near> find(std::uint32_t group, std::span<const std::uint8_t> open);
    /// Valid until the next call.
    const PlacedBody& body(const Near& near)
    {
        return near.body & is_copied ? copied_.body(near.body ^ is_copied, near.configuration) : bodies_[near.body];
    }
    const Eigen::Isometry3d& pose_at(std::uint32_t slot, std::uint32_t configuration) const
    {
        const Eigen::Isometry3d* const own = copied_.pose_at(slot, configuration);
        return own ? *own : tests_.pose_at(slot);
    }

private:
    static constexpr std::uint32_t is_copied = 0x80000000u;

    void find_copied(std::uint32_t group, std::span<const std::uint8_t> open);
    bool is_own(std::uint32_t slot) const;
    void find_together(std::uint32_t group, std::span<const std::uint8_t> open);
    void find_one_by_one(std::uint32_t group, std::span<const std::uint8_t> open);

    std::span<const GroupCover> groups_;
    WorldAccess::PlacedTests& tests_;
    CollisionFilter filter_;
    std::vector<std::uint32_t> own_;
    const GroupCentres* centres_ = nullptr;
    const NearParts* parts_ = nullptr;
    PlacedBodies bodies_;
    CopiedPlaces copied_;
    std::vector<std::vector<std::uint32_t>> around_; ///< by group: bodies around it in all configurations
    std::vector<Aabb> queries_;
    std::vector<std::uint32_t> of_; ///< configurations of queries_
    std::vector<Near> near_;
    std::vector<std::uint64_t> masks_; ///< by configuration: bits of around_
    std::vector<std::uint8_t> bits_;
};

} // namespace oncollide
