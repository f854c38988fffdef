#include "peers/fcl_robot.hpp"

#include <algorithm>
#include <limits>
#include <map>

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include "fcl/fcl_pair.hpp"

namespace oncollide::tools {

struct FclRobot::Impl {
    struct Part {
        std::uint32_t link;
        Eigen::Isometry3d pose;
        std::unique_ptr<fcl::CollisionObjectd> object;
    };

    std::vector<Part> parts;
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> obstacles;
    fcl::DynamicAABBTreeCollisionManagerd robot;
    std::unique_ptr<fcl::DynamicAABBTreeCollisionManagerd> environment;
    std::vector<std::uint8_t> tested; ///< by two links
    std::size_t links = 0;
    bool found = false;
    double least = 0;

    static bool test(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, Impl& me)
    {
        const fcl::CollisionRequestd request(1, false);
        thread_local fcl::CollisionResultd result;
        result.clear();
        fcl::collide(a, b, request, result);
        return me.found = result.isCollision();
    }
    static bool is_tested(const fcl::CollisionObjectd* a, const fcl::CollisionObjectd* b, const Impl& me)
    {
        const auto link = [](const fcl::CollisionObjectd* object) {
            return reinterpret_cast<std::uintptr_t>(object->getUserData());
        };
        return me.tested[link(a) * me.links + link(b)];
    }
    static bool with_environment(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* data)
    {
        return test(a, b, *static_cast<Impl*>(data));
    }
    static bool with_itself(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* data)
    {
        Impl& me = *static_cast<Impl*>(data);
        return is_tested(a, b, me) && test(a, b, me);
    }
    /// Sets `dist`, the manager's cutoff, to the least distance so far; true: none can be less.
    static bool measure(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, Impl& me, double& dist)
    {
        const fcl::DistanceRequestd request(true);
        fcl::DistanceResultd result;
        me.least = dist = std::min(me.least, fcl::distance(a, b, request, result));
        return me.least <= 0;
    }
    static bool distance_to_environment(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* data, double& dist)
    {
        return measure(a, b, *static_cast<Impl*>(data), dist);
    }
    static bool distance_to_itself(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* data, double& dist)
    {
        Impl& me = *static_cast<Impl*>(data);
        dist = me.least;
        return is_tested(a, b, me) && measure(a, b, me, dist);
    }
    void place(std::span<const Eigen::Isometry3d> poses)
    {
        for (const Part& part : parts) {
            part.object->setTransform(poses[part.link] * part.pose);
            part.object->computeAABB();
        }
    }
};

FclRobot::FclRobot(const RobotDescription& robot) : impl_(std::make_unique<Impl>())
{
    Impl& me = *impl_;
    me.links = robot.links.size();
    me.tested.assign(me.links * me.links, 1);
    for (std::uint32_t i = 0; i < me.links; ++i) me.tested[i * me.links + i] = 0;
    for (const auto& [a, b] : robot.excluded) me.tested[a * me.links + b] = me.tested[b * me.links + a] = 0;
    std::map<const Geometry*, FclGeometry> models;
    for (std::uint32_t i = 0; i < me.links; ++i)
        for (const LinkGeometry& collision : robot.links[i].collision) {
            FclGeometry& model = models[collision.geometry.get()];
            if (!model) model = make_fcl_geometry(collision.geometry->data, FclNodes::obbrss);
            auto object = std::make_unique<fcl::CollisionObjectd>(model, collision.pose);
            object->setUserData(reinterpret_cast<void*>(std::uintptr_t{i}));
            me.robot.registerObject(object.get());
            me.parts.push_back({i, collision.pose, std::move(object)});
        }
    me.robot.setup();
    set_environment({});
}

FclRobot::~FclRobot() = default;

void FclRobot::set_environment(std::span<const LinkGeometry> obstacles)
{
    Impl& me = *impl_;
    me.environment = std::make_unique<fcl::DynamicAABBTreeCollisionManagerd>();
    me.obstacles.clear();
    for (const LinkGeometry& obstacle : obstacles) {
        me.obstacles.push_back(std::make_unique<fcl::CollisionObjectd>(
            make_fcl_geometry(obstacle.geometry->data, FclNodes::obbrss), obstacle.pose));
        me.environment->registerObject(me.obstacles.back().get());
    }
    me.environment->setup();
}

bool FclRobot::self_collides(std::span<const Eigen::Isometry3d> links)
{
    Impl& me = *impl_;
    me.place(links);
    me.robot.update();
    me.found = false;
    me.robot.collide(&me, Impl::with_itself);
    return me.found;
}

bool FclRobot::collides(std::span<const Eigen::Isometry3d> links)
{
    if (self_collides(links)) return true;
    Impl& me = *impl_;
    for (const Impl::Part& part : me.parts) {
        me.environment->collide(part.object.get(), &me, Impl::with_environment);
        if (me.found) return true;
    }
    return false;
}

double FclRobot::distance(std::span<const Eigen::Isometry3d> links)
{
    Impl& me = *impl_;
    me.place(links);
    me.robot.update();
    me.least = std::numeric_limits<double>::infinity();
    me.robot.distance(&me, Impl::distance_to_itself);
    for (const Impl::Part& part : me.parts) {
        if (me.least <= 0) break;
        me.environment->distance(part.object.get(), &me, Impl::distance_to_environment);
    }
    return me.least;
}

} // namespace oncollide::tools
