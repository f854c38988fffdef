#pragma once
#include <algorithm>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include <oncollide/base/threads/idle_objects.hpp>
#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/robots/cover.hpp>
#include <oncollide/robots/kinematics.hpp>
#include <oncollide/robots/part_solids.hpp>
#include <oncollide/robots/robot.hpp>

namespace oncollide {

class Clearances;
class JointCells;

/// The bounding spheres of a part, to rule out pairs: the first contains the part, as do the others together.
struct PartSpheres {
    std::uint32_t first, count; ///< range in Impl::spheres, without the sphere around the whole part
    CoverSphere whole;
};

struct Robot::Impl {
    /// A geometry of a link, or an attached object.
    struct Part {
        std::uint32_t link;
        ModelId model;
        Eigen::Isometry3d pose; ///< in the link's frame
        bool is_at_link;        ///< the pose is the identity
        PartSpheres cover;
        std::vector<std::uint32_t> touching;        ///< links that are not tested with this part
        std::shared_ptr<const PartSolids> solids{}; ///< solids of a mesh, in its own frame; else null
    };
    struct PartPair {
        std::uint32_t a, b;
        std::uint32_t seen_from; ///< the link between them from which the bounds on their motions are the least
    };
    /// The parts of a link, or one attached object: one bounding sphere can rule them out together.
    struct Group {
        std::uint32_t first, end, link;
        CoverSphere whole;
    };
    struct GroupPair {
        std::uint32_t a, b;
        std::uint32_t first, end; ///< range in pairs
        std::uint32_t near = 0;   ///< sampled configurations in which bounding spheres overlap
    };

    struct IdleCheckers; ///< robot_check.cpp
    static std::shared_ptr<IdleCheckers> no_checkers();
    struct IdleFinders; ///< distances/robot_distances.cpp
    static std::shared_ptr<IdleFinders> no_finders();

    Impl(World& world, RobotDescription given, const Eigen::Isometry3d& base_pose);
    static RobotDescription checked(RobotDescription given);

    void add_part(std::uint32_t link, ModelId model, const Eigen::Isometry3d& pose, std::vector<CoverSphere> spheres,
                  std::span<const std::uint32_t> touching);
    /// Adds a group of the parts from `first` on.
    void add_group(std::uint32_t first);
    /// Call it when groups have changed: it makes their covers, and lists the pairs of parts that are tested.
    void take_in_groups();
    void find_pairs();
    /// Chooses random numbers within the limits of all joints. Spans are the distances between the limits.
    void choose_numbers(std::uint64_t k, std::vector<double>& numbers, std::vector<double>& spans) const;
    void choose_views();
    void sort_pairs();
    /// Throws Error{usage} if the World is not this robot's.
    void check_world(const World& world) const;
    /// Throws Error{bad_data} for a pose that is not rigid.
    void check_pose(const std::string& of, const Eigen::Isometry3d& pose) const;
    /// Throws Error{usage}.
    void check_link(const char* call, std::uint32_t link) const;
    /// Throws Error{usage} if the robot has bodies.
    void refuse_with_bodies(const char* call) const;
    void check_width(std::size_t numbers) const;
    /// Throws Error{usage} if there are not `count` configurations, and as check_configuration() without limits, with
    /// the call and the number of the item.
    static void check_numbers(const char* call, const char* item, const Robot& robot, std::span<const double> numbers,
                              std::size_t count);
    bool allows(std::uint32_t link, BodyId body) const
    {
        return !allowed_bodies.empty() && std::ranges::binary_search(allowed_bodies, std::pair(link, body));
    }
    Eigen::Isometry3d pose_of(const Part& part, const Eigen::Isometry3d* links) const
    {
        return part.is_at_link ? links[part.link] : links[part.link] * part.pose;
    }

    /// The slots of the robot's bodies that are still in the World, sorted; slots of removed bodies may hold other
    /// bodies by now.
    std::vector<std::uint32_t> own_slots(const World& world) const;

    /// Call it when the base or the parts have changed.
    void find_sound_poses();
    /// Throws Error{bad_data} for a pose that a World refuses, with the number of the configuration.
    void check_poses(const Eigen::Isometry3d* links, std::size_t configuration) const;

    /// Upper bound of the factor by which the poses of parts stretch lengths: the base, the origins and the part's own
    /// pose each count as rigid up to 1e-6 (why_not_rigid()).
    double stretch() const { return 1 + 2e-6 * static_cast<double>(description.joints.size() + 2); }

    /// Share of lengths by which links that are not quite rigid, and rounding to float, change distances at most.
    double rounding() const { return 4 * (stretch() - 1) + 0x1p-17; }

    /// The grids of pairs between which few joints act, for a clearance.
    std::shared_ptr<JointCells> joint_cells(double clearance) const;

    RobotDescription description;
    Kinematics tree;
    std::vector<double> neutral; ///< Robot::neutral()
    Eigen::Isometry3d base;
    std::vector<Part> parts;          ///< by links, then attached objects
    std::vector<CoverSphere> spheres; ///< spheres of all parts, in the frames of their links
    std::size_t attached_from = 0;
    std::size_t spheres_of_links = 0;
    std::vector<Group> groups;      ///< groups of all parts, in order
    std::vector<GroupCover> covers; ///< by group
    /// A World accepts the poses of all parts in every configuration: they are rigid and not too far away.
    bool has_sound_poses = false;
    std::shared_ptr<IdleCheckers> idle;        ///< idle checkers of check(), for the parts as they are
    std::shared_ptr<IdleFinders> idle_finders; ///< the same, of distances()
    mutable OrderedMutex<LockRank::joint_cells> cells_mutex;
    mutable std::shared_ptr<JointCells> cells; ///< grids of check_edges(), for the parts as they are; null: none yet
    std::vector<PartPair> pairs;
    std::vector<GroupPair> group_pairs; ///< those most often near each other first
    RobotPadding padding;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> allowed_links; ///< a < b, sorted
    std::vector<std::pair<std::uint32_t, BodyId>> allowed_bodies;       ///< sorted
    std::vector<BodyId> bodies;
    ModelId any_model{}; ///< identifies the World
};

/// Tests whether bounding spheres of two parts come closer than the clearance, and how far apart they are.
class SphereCull {
public:
    SphereCull(const Robot::Impl& robot, double clearance);
    /// Places the spheres at a configuration.
    void place(const Eigen::Isometry3d* links);
    /// False: the groups are certainly farther apart than the clearance.
    bool groups_near(std::uint32_t a, std::uint32_t b) const { return meet(groups_[a], groups_[b], 0); }
    /// The same for two parts, with the clearance and `reach`.
    bool near(std::uint32_t a, std::uint32_t b, double reach = 0);

    // Lower bounds of distances; 0: unknown.
    double gap_of_groups(std::uint32_t a, std::uint32_t b) const { return gap(groups_[a], groups_[b]); }
    double gap_of_parts(std::uint32_t a, std::uint32_t b);
    double gap_of_group(std::uint32_t a, const Aabb& box) const;
    double gap_of_part(std::uint32_t a, const PlacedBox& box);
    Aabb box_of_group(std::uint32_t a) const; ///< around its bounding sphere, in the world

private:
    struct Placed {
        double x, y, z, radius;
    };
    bool meet(const Placed& a, const Placed& b, double reach) const;
    static double gap(const Placed& a, const Placed& b);
    const Placed* spheres_of(std::uint32_t part); ///< the first sphere is around the whole part
    Placed placed(const CoverSphere& sphere, std::uint32_t link) const;

    const Robot::Impl& robot_;
    const double clearance_, stretch_;
    const Eigen::Isometry3d* links_ = nullptr;
    std::vector<Placed> groups_, spheres_; ///< spheres_: for each part, first the sphere around the whole part, then
                                           ///< the others
    std::vector<std::uint8_t> placed_;     ///< by part
};

/// Objects that check configurations, kept with their memory from call to call.
template <class Checker>
struct IdleCheckersOf : IdleObjects<Checker, LockRank::robot_checkers> {
    struct GiveBack {
        IdleCheckersOf* to = nullptr;
        void operator()(Checker* checker) const { to->give_back(std::unique_ptr<Checker>(checker)); }
    };
    using Lease = std::unique_ptr<Checker, GiveBack>;

    /// An idle one, or a new one, that has begun() with the World as it is now.
    Lease lease(const auto& robot, const World& world, const auto&... what)
    {
        std::unique_ptr<Checker> checker = this->take();
        if (!checker || !checker->is_for(world)) checker = std::make_unique<Checker>(robot, world);
        checker->begin(world, what...);
        return Lease(checker.release(), GiveBack{this});
    }
};

/// Calls work(checker, first, count) for chunks of `items`, on the World's threads, with one checker of make() each.
template <class Make, class Work>
void each_chunk(const World& world, std::size_t items, std::size_t chunk, Make make, Work work)
{
    const Settings& settings = world.settings();
    const ExecutorScope scope(settings.executor);
    const int threads = thread_count(settings);
    std::vector<decltype(make())> checkers(static_cast<std::size_t>(threads));
    parallel_chunks((items + chunk - 1) / chunk, 1, threads, [&](std::size_t begin, std::size_t end, int thread) {
        auto& checker = checkers[static_cast<std::size_t>(thread)];
        if (!checker) checker = make();
        for (std::size_t k = begin; k < end; ++k) work(*checker, k * chunk, std::min(chunk, items - k * chunk));
    });
}

} // namespace oncollide
