#pragma once
#include <random>
#include <string>
#include <vector>

#include <oncollide/pipeline/world.hpp>

#include "temporary_folder.hpp"

namespace oncollide::test {

/// A robot of every kind of shape and of most kinds of joint, in a folder of its own.
class SmallRobot {
public:
    SmallRobot()
    {
        folder_.write("wedge.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
        urdf = folder_.write("arm.urdf", text);
        srdf = folder_.write("arm.srdf", semantic);
    }
    /// The URDF with a part of its text replaced, which must be there.
    std::filesystem::path changed(const std::string& from, const std::string& to) const
    {
        return folder_.write("changed.urdf", replaced(text, from, to));
    }
    std::filesystem::path changed_srdf(const std::string& from, const std::string& to) const
    {
        return folder_.write("changed.srdf", replaced(semantic, from, to));
    }
    const TemporaryFolder& folder() const { return folder_; }

    std::filesystem::path urdf, srdf;

    inline static const std::string text = R"(<?xml version="1.0"?>
<robot name="arm" xmlns:xacro="http://ros.org/wiki/xacro">
  <link name="base"><visual><geometry><mesh filename="package://absent/no.dae"/></geometry></visual>
    <collision><geometry><box size="0.3 0.3 0.5"/></geometry></collision></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.1" rpy="0 0 0.5"/><axis xyz="0 0 2"/></joint>
  <link name="upper">
    <collision><origin xyz="0 0 0.25"/><geometry><cylinder radius="0.04" length="0.4"/></geometry></collision></link>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 0.5" rpy="0.05 0 0"/><axis xyz="0 1 0"/><limit lower="-3" upper="2.5"/></joint>
  <link name="lower">
    <collision><origin xyz="0 0 0.05"/><geometry><mesh filename="wedge.obj" scale="0.05 0.05 0.4"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic"><parent link="lower"/><child link="left"/>
    <origin xyz="0 0 0.5"/><axis xyz="1 0 0"/><limit lower="0.03" upper="0.1"/></joint>
  <link name="left"><collision><geometry><sphere radius="0.02"/></geometry></collision></link>
  <joint name="slide2" type="prismatic"><parent link="lower"/><child link="right"/>
    <origin xyz="0 0 0.5"/><axis xyz="1 0 0"/><limit lower="-1" upper="1"/>
    <mimic joint="slide" multiplier="-2" offset="0.01"/></joint>
  <link name="right">
    <collision><geometry><mesh filename="package://robot/wedge.obj" scale="-0.02 0.02 0.02"/></geometry></collision></link>
  <joint name="tip" type="fixed"><parent link="right"/><child link="camera"/></joint>
  <link name="camera"/>
</robot>
)";
    inline static const std::string semantic = R"(<robot name="arm">
  <group name="chain"><chain base_link="base" tip_link="lower"/></group>
  <group name="hand"><link name="left"/><joint name="slide2"/></group>
  <group name="all"><group name="chain"/><group name="hand"/></group>
  <group_state name="bent" group="chain"><joint name="elbow" value="1.5"/></group_state>
  <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
  <disable_collisions link1="lower" link2="upper" reason="Adjacent"/>
</robot>
)";

private:
    static std::string replaced(std::string all, const std::string& from, const std::string& to)
    {
        const std::size_t at = all.find(from);
        if (at == all.npos) std::abort();
        return all.replace(at, from.size(), to);
    }
    TemporaryFolder folder_;
};

/// Random configurations, within the limits of the small robot.
inline std::vector<double> random_numbers(std::size_t count)
{
    std::mt19937 random(5);
    std::vector<double> numbers;
    for (std::size_t i = 0; i < count; ++i)
        for (const auto& [low, high] : {std::pair{-3.2, 3.2}, {-3.0, 2.5}, {0.03, 0.1}})
            numbers.push_back(std::uniform_real_distribution(low, high)(random));
    return numbers;
}

/// Posts around the robot.
inline std::vector<BodyId> add_posts(World& world)
{
    std::vector<BodyId> posts;
    const ModelId post = world.models().add(Box{{0.05, 0.05, 0.3}});
    for (int i = 0; i < 6; ++i) {
        const double angle = i * 1.1;
        const Eigen::Translation3d place(0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.1 * i + 0.2);
        posts.push_back(world.bodies().add({.model = post, .pose = Eigen::Isometry3d(place), .is_static = true}));
    }
    return posts;
}

} // namespace oncollide::test
