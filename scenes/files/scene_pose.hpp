#pragma once
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/motion.hpp>

namespace oncollide {

// The pose of a body in a scene file. Private to scenes.

/// The pose of a body whose entry has no position and no rotation: its first key's pose, else the identity.
Eigen::Isometry3d default_pose(const Motion& motion);

/// The rotation of a body in a scene file: a quaternion [x, y, z, w], or the rows of its matrix.
Eigen::Matrix3d read_rotation(const Node& node, std::vector<std::string>& warnings);

/// True if all entries are the same numbers, signs of zeros included.
bool same_bits(const Eigen::Vector3d& a, const Eigen::Vector3d& b);
bool same_bits(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

/// An entry that read_rotation converts to exactly `rotation`: a quaternion if possible, else the matrix (a
/// quaternion's matrix is rounded, so most matrices have no quaternion that restores them bit for bit).
nlohmann::ordered_json rotation_entry(const Eigen::Matrix3d& rotation);

} // namespace oncollide
