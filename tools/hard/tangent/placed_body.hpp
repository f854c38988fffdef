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

/// A map of one cell, whose least corner is the origin.
OccupancyMap one_cell(double side);

/// Counts what becomes of the two by exact tests, by both bounding volumes alone, and by FCL. `meet` is the truth.
/// @param what  names the case in faults
void judge_meeting(const PlacedBody& a, const PlacedBody& b, bool meet, const std::string& what, Tally& tally);

/// The same where the surfaces are off by up to some error: no result may be surer than the truth about the surfaces as
/// given allows.
/// @param distance  the true one; 0 where they meet
void judge_bounds(const PlacedBody& a, const PlacedBody& b, long double distance, const std::string& what,
                  Tally& tally);

} // namespace oncollide::tools
