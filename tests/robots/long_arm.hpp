#pragma once
#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "random_pose.hpp"
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/robots/robot.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::test {

/// Links with meshes, shapes, several parts, and many spheres.
inline RobotDescription long_arm()
{
    RobotDescription robot;
    robot.name = "long arm";
    const auto add = [](RobotLink& link, GeometryData data, const Eigen::Vector3d& at) {
        Eigen::Isometry3d pose = random_pose(std::hash<std::string>()(link.name), 0);
        pose.translation() = at;
        link.collision.push_back({std::make_shared<const Geometry>(Geometry{link.name, std::move(data), {}}), pose});
    };
    for (std::uint32_t i = 0; i < 6; ++i) {
        RobotLink link{"link" + std::to_string(i), {}};
        if (i == 1) add(link, make_torus_mesh(0.2, 0.06, 400), {0, 0, 0.2});
        if (i == 2) add(link, Shape(Box{{0.03, 0.04, 0.2}}), {0, 0, 0.2});
        if (i == 3) {
            add(link, make_box_mesh({0.05, 0.05, 0.1}), {0, 0, 0.1});
            add(link, make_torus_knot_mesh(2, 3, 0.12, 0.05, 0.02, 300), {0.1, 0, 0.25});
            add(link, Shape(Cylinder{0.03, 0.2}), {-0.05, 0, 0.2});
        }
        if (i >= 4)
            for (std::uint64_t k = 0; k < 100; ++k)
                add(link, Shape(Sphere{0.02 + 0.02 * u01(i, k, 3)}),
                    {0.2 * u01(i, k, 0) - 0.1, 0.2 * u01(i, k, 1) - 0.1, 0.4 * u01(i, k, 2)});
        robot.links.push_back(std::move(link));
        if (i == 0) continue;
        RobotJoint joint;
        joint.name = "joint" + std::to_string(i), joint.kind = JointKind::revolute;
        joint.parent = i - 1, joint.child = i, joint.lower = -2.5, joint.upper = 2.5;
        joint.origin.translation().z() = i == 1 ? 0.1 : 0.4;
        joint.axis = i % 2 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d(0, 1, 0.5).normalized();
        robot.joints.push_back(joint);
        robot.excluded.push_back({i - 1, i});
    }
    return robot;
}

/// Bodies of many kinds around the robot.
inline void add_bodies(World& world, std::size_t count, double reach, std::uint64_t seed)
{
    const std::vector<ModelId> models{
        world.models().add(Box{{0.3, 0.3, 0.02}}),
        world.models().add(Cylinder{0.1, 0.3}),
        world.models().add(Sphere{0.15}),
        world.models().add(Capsule{0.05, 0.4}),
        world.models().add(make_torus_mesh(0.3, 0.1, 500)),
        world.models().add(Box{{0.02, 0.02, 0.02}}),
        world.models().add(ConvexHull{{{0, 0, 0}, {0.2, 0, 0}, {0, 0.3, 0}, {0, 0, 0.4}}})};
    for (std::size_t i = 0; i < count; ++i)
        world.bodies().add(
            {.model = models[i % models.size()], .pose = random_pose(seed + i, reach), .is_static = true});
    Eigen::Isometry3d floor = Eigen::Isometry3d::Identity();
    floor.translation().z() = -1.4;
    world.bodies().add({.model = world.models().add(HalfSpace{}), .pose = floor, .is_static = true});
    const std::vector<MapCell> cells{{9, 9, 3, 1}, {9, 9, 4, 1}, {-8, 9, 3, 1}};
    world.bodies().add({.model = world.models().add(make_occupancy_map("map", 0.1, cells)), .is_static = true});
}

inline std::vector<double> numbers_of(const Robot& robot, std::size_t count, double step)
{
    std::vector<double> numbers;
    std::mt19937 random(7);
    std::vector<double> at(robot.width());
    for (std::size_t i = 0; i < count; ++i)
        for (double& number : at) {
            number = std::clamp(number + step * std::uniform_real_distribution(-2.5, 2.5)(random), -2.5, 2.5);
            numbers.push_back(number);
        }
    return numbers;
}

} // namespace oncollide::test
