// Robots, their spheres, and planning problems.
#include "robots/small_robot.hpp"
#include "seeds.hpp"

namespace oncollide::test {

std::vector<std::string> urdf_seeds()
{
    std::string text = SmallRobot::text;
    text.replace(text.find("package://robot/"), 16, ""); // beside the file
    std::string models = text;                           // of Gazebo, and a mimic joint without limits
    const std::string limit = R"(<limit lower="-1" upper="1"/>)";
    models.replace(models.find(limit), limit.size(), "");
    models.replace(models.find("\"wedge.obj"), 1, "\"model://");
    return {
        text, models,
        R"(<robot name="r"><link name="a"/><joint name="j" type="planar"><parent link="a"/><child link="b"/></joint>)"
        R"(<joint name="k" type="floating"><parent link="b"/><child link="c"/></joint><link name="b"/>)"
        R"(<link name="c"><collision><geometry><capsule radius="1" length="2"/></geometry></collision></link></robot>)"};
}

std::vector<std::string> srdf_seeds()
{
    return {SmallRobot::semantic,
            R"(<robot name="arm"><group name="g"><link name="base"/><passive_joint name="slide"/></group>)"
            R"(<disable_default_collisions link="left"/><enable_collisions link1="left" link2="base"/></robot>)"};
}

std::vector<std::string> mjcf_seeds()
{
    return {
        R"(<mujoco model="m"><compiler angle="radian" eulerseq="XYZ"/><include file="part.xml"/>
<option><flag filterparent="disable"/></option>
<default><geom type="capsule" size="0.1 0.2"/><default class="a"><geom euler="1 0 0"/><joint type="slide"/></default></default>
<asset><mesh file="wedge.obj" scale="1 -1 1" refpos="0 0 1" refquat="1 0 0 1"/>
<mesh name="h" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/><mesh name="f" vertex="0 0 0 1 0 0 0 1 0" face="0 1 2"/></asset>
<worldbody><geom type="plane"/><frame pos="1 0 0"><body name="b" childclass="a" axisangle="0 0 1 2"><freejoint/>
<geom fromto="0 0 0 1 0 0"/><geom name="g" type="mesh" mesh="wedge" contype="2"/><geom type="mesh" mesh="h"/>
<body name="c" zaxis="1 0 0"><joint ref="1" range="0 1"/><joint type="hinge" pos="1 0 0"/>
<geom name="k" type="ellipsoid" size="1 2 3" xyaxes="1 0 0 0 1 0"/><geom type="mesh" mesh="f"/></body></body></frame></worldbody>
<contact><exclude body1="b" body2="c"/><pair geom1="g" geom2="k"/></contact>
<keyframe><key qpos="0 0 0 1 0 0 0 0 0"/></keyframe></mujoco>)",
        R"(<mujoco><worldbody><body><joint type="slide"/><geom type="box" size="1 1 1" quat="1 2 3 4"/></body></worldbody></mujoco>)"};
}

std::vector<std::string> problem_seeds()
{
    return {R"(name: shelf
world:
  collision_objects:
    - id: board
      pose: &place {position: [0.5, 0, 1], orientation: [0, 0, 0.6, 0.8]}
      primitives:
        - {type: box, dimensions: [1, 0.3, 0.02]}
        - {type: cylinder, dimensions: [0.2, 0.04]}
      primitive_poses:
        - *place
        - position: [0.1, 0.2, 0.12]
          orientation: [0, 0, 0, 1]
    - id: ball
      primitives: [{type: sphere, dimensions: [0.1]}]
      primitive_poses: [{position: [1, 1, 1], orientation: [1, 0, 0, 0]}]
)",
            "{world: {collision_objects: []}}"};
}

std::vector<std::string> request_seeds()
{
    return {R"(start_state:
  joint_state:
    name: [shoulder, elbow]
    position: [0.5, -1.25e-1]
goal_constraints:
  - joint_constraints:
      - joint_name: shoulder
        position: 1.5
        weight: 1
      - {joint_name: elbow, position: .5}
)"};
}

std::vector<std::string> sphere_model_seeds()
{
    return {R"(robot_cfg:
  kinematics:
    collision_spheres:
      base:
        - center: [0, 0.1, 0]
          radius: 0.2
        - {"center": [1, 2, 3], "radius": -10}
      no_link: []
)",
            "collision_spheres: {upper: [{center: [0, 0, 0.5], radius: .1}]}"};
}

} // namespace oncollide::test
