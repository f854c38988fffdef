#pragma once
#include <array>
#include <vector>

#include "clash/clashes.hpp"

namespace oncollide::tools {

/// The camera of a picture. Lengths in the unit of the report.
struct ClashView {
    Eigen::Vector3d from; ///< unit, towards the camera
    Eigen::Vector3d middle;
    double radius; ///< radius of the ball that the close-up shows
};

/// The contents of a picture of a clash.
struct ClashScenery {
    std::vector<std::array<Eigen::Vector3d, 2>> lines; ///< where surfaces meet; apart: between the nearest points
    Aabb box_a, box_b, part;                           ///< part: around the contact
    ClashView view;
};

/// Where the surfaces of a clash meet; none if the parts are apart, one is enclosed, or both are the same.
std::vector<Contact> contacts_of(const Clashes& found, const Clash& clash);
/// @param contacts  contacts_of(clash)
ClashScenery scenery_of(const PartList& parts, const Clash& clash, const std::vector<Contact>& contacts);

} // namespace oncollide::tools
