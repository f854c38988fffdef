#pragma once
#include <memory>
#include <string>
#include <vector>

#include <oncollide/pipeline/world.hpp>

#include "clash/part_list.hpp"

namespace oncollide::tools {

/// What two parts that are too close mean to the reader of a report.
enum class ClashStatus : std::uint8_t {
    fresh,   ///< to be looked at; in reports "new"
    same,    ///< the baseline has it, too
    ignored, ///< the list of known pairs has it
    contact, ///< the parts only touch, and touching is no clash
};
std::string_view name_of(ClashStatus status);

/// Two parts that touch, cross, enclose or are near each other. Lengths in the unit of the report.
struct Clash {
    std::uint32_t a, b;          ///< in PartList::parts, a < b
    ContactKind kind;            ///< enclosed, crossing, touching or near
    Penetration reach{};         ///< of what is not near
    bool tolerated = false;      ///< touching: they cross by less than the tolerance
    double lower = 0, upper = 0; ///< near: certified bounds on the distance
    Eigen::Vector3d where =
        Eigen::Vector3d::Zero(); ///< the middle of what both have in common, or between the nearest points
    Eigen::Vector3d nearest_a = Eigen::Vector3d::Zero(), nearest_b = Eigen::Vector3d::Zero(); ///< near
    ClashStatus status = ClashStatus::fresh;
    std::string was{}; ///< the kind that the baseline has, if that was less severe

    /// How far one reaches into the other, to sort by: how thick the overlap is, or for parts that are not closed how
    /// long the contact curve.
    double severity() const;
};

struct ClashSettings {
    double clearance = 0;  ///< nearer parts are near
    double tolerance = 0;  ///< parts that certainly overlap by no more touch
    bool touching = false; ///< touching is a clash
    int threads = 0;
};

/// A World that holds the parts, and the pairs of them that are too close, the most severe first.
struct Clashes {
    std::unique_ptr<World> world;
    std::vector<BodyId> bodies; ///< by part
    std::vector<Clash> list;
    std::vector<std::string> open; ///< names of parts that are not closed: nothing is found inside them
    std::size_t pairs = 0;         ///< whose boxes overlap

    PairOfBodies pair(const Clash& clash) const { return {bodies[clash.a], bodies[clash.b]}; }
};

/// All pairs of parts of different groups, exactly.
Clashes find_clashes(const PartList& parts, const ClashSettings& settings);

/// Is `a` to be listed before `b`: enclosed, crossing, touching, near; of one kind the deeper or nearer one first.
bool more_severe(const Clash& a, const Clash& b);

} // namespace oncollide::tools
