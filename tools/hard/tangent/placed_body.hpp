#pragma once
#include <string>

#include <oncollide/scenes/geometry.hpp>

#include "hard/tally.hpp"

namespace oncollide::tools {

struct PlacedBody {
    GeometryData geometry;
    Eigen::Isometry3d pose;
};

inline Eigen::Isometry3d moved_to(const Eigen::Vector3d& at)
{
    return Eigen::Isometry3d(Eigen::Translation3d(at));
}

/// A map of one cell, whose lowest corner is the origin.
OccupancyMap one_cell(double side);

/// Counts the results of exact tests, of both bounding volumes without them, and of FCL. `meet` is the truth.
/// @param what  names the case in faults
void judge_meeting(const PlacedBody& a, const PlacedBody& b, bool meet, const std::string& what, Tally& tally);

/// The same for surfaces with an error: no result may be more certain than the truth about the surfaces as given
/// allows.
/// @param distance  the true distance; 0 if they meet
void judge_bounds(const PlacedBody& a, const PlacedBody& b, long double distance, const std::string& what,
                  Tally& tally);

} // namespace oncollide::tools
