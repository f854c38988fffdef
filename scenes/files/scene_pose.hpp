#pragma once
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide {

// How a scene file holds the pose of a body. Private to scenes.

/// The pose of a body whose entry gives neither position nor rotation: where its keys put it, else the identity.
Eigen::Isometry3d default_pose(const Motion& motion);

/// The rotation of a body in a scene file: a quaternion [x, y, z, w], or the rows of its matrix.
Eigen::Matrix3d read_rotation(const Node& node, std::vector<std::string>& warnings);

/// True when all entries are the same numbers, zeros' signs included.
bool same_bits(const Eigen::Vector3d& a, const Eigen::Vector3d& b);
bool same_bits(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

/// What read_rotation turns into exactly `rotation`: the quaternion where it does, else the matrix (a quaternion's
/// matrix is rounded, so most matrices have no quaternion that gives them back bit for bit).
nlohmann::ordered_json rotation_entry(const Eigen::Matrix3d& rotation);

} // namespace oncollide
