#pragma once
#include <memory>
#include <string>
#include <vector>

#include <oncollide/pipeline/world.hpp>

#include "clash/part_list.hpp"

namespace oncollide::tools {

/// Status of a pair of parts in a report.
enum class ClashStatus : std::uint8_t {
    fresh,   ///< not known yet; in reports "new"
    same,    ///< also in the baseline
    ignored, ///< in the list of known pairs
    contact, ///< the parts only touch, and touching is not a clash
};
std::string_view name_of(ClashStatus status);

/// Two parts that touch, cross, enclose or are near each other. Lengths in the unit of the report.
struct Clash {
    std::uint32_t a, b;          ///< in PartList::parts, a < b
    ContactKind kind;            ///< enclosed, crossing, touching or near
    Penetration reach{};         ///< unless near
    bool tolerated = false;      ///< touching: they cross by no more than the tolerance
    double lower = 0, upper = 0; ///< near: certified bounds on the distance
    Eigen::Vector3d where =
        Eigen::Vector3d::Zero(); ///< the centre of the overlap; near: midway between the nearest points
    Eigen::Vector3d nearest_a = Eigen::Vector3d::Zero(), nearest_b = Eigen::Vector3d::Zero(); ///< near
    ClashStatus status = ClashStatus::fresh;
    std::string was{}; ///< the kind in the baseline, if less severe

    /// Sorting key: the thickness of the overlap, or, for parts that are not closed, the length of the contact curve.
    double severity() const;
};

struct ClashSettings {
    double clearance = 0;  ///< parts closer than this are near
    double tolerance = 0;  ///< parts that certainly overlap by no more than this touch
    bool touching = false; ///< touching is a clash
    int threads = 0;
};

/// A World that holds the parts, and the pairs of parts that are too close, the most severe first.
struct Clashes {
    std::unique_ptr<World> world;
    std::vector<BodyId> bodies; ///< by part
    std::vector<Clash> list;
    std::vector<std::string> open; ///< names of parts that are not closed: parts inside them are not found
    std::size_t pairs = 0;         ///< number of pairs whose AABBs overlap

    PairOfBodies pair(const Clash& clash) const { return {bodies[clash.a], bodies[clash.b]}; }
};

/// Decides all pairs of parts of different groups, exactly.
Clashes find_clashes(const PartList& parts, const ClashSettings& settings);

/// True if `a` is listed before `b`: enclosed, crossing, touching, near; within a kind the deeper or nearer pair first.
bool more_severe(const Clash& a, const Clash& b);

} // namespace oncollide::tools
