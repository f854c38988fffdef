#pragma once
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <oncollide/narrowphase/overlap/common_ball.hpp>
#include <oncollide/pipeline/world.hpp>

#include "clash/parts/part_list.hpp"

namespace oncollide::tools {

/// How two parts clash, the most severe first.
enum class ClashKind : std::uint8_t {
    duplicate, ///< both have the same geometry at the same place
    enclosed,  ///< as in ContactKind, like the following kinds
    crossing,
    within, ///< their overlap or gap is smaller than their meshes deviate from the true surfaces: it may be none
    touching,
    near,
};
inline constexpr std::array clash_kinds{ClashKind::duplicate, ClashKind::enclosed, ClashKind::crossing,
                                        ClashKind::within,    ClashKind::touching, ClashKind::near};
std::string_view name_of(ClashKind kind);

/// Status of a pair of parts in a report.
enum class ClashStatus : std::uint8_t {
    fresh,   ///< not known yet; in reports "new"
    active,  ///< also in the baseline
    ignored, ///< in the list of known pairs
    contact, ///< the parts only touch, or may do so (within), and touching is not a clash
};
std::string_view name_of(ClashStatus status);

/// Clearance and tolerance of a pair of parts, in the unit of the report.
struct PairLimits {
    double clearance, tolerance;
    bool skip = false; ///< the pair is not compared
};

/// Two parts that are the same, or touch, cross, enclose or are near each other. Lengths in the unit of the report.
struct Clash {
    std::uint32_t a, b; ///< in PartList::parts, a < b
    ClashKind kind;
    PairLimits limits;   ///< of the settings or the matrix
    std::string id{};    ///< as clash_id()
    Penetration reach{}; ///< set unless the parts are apart; for a duplicate only the box and the thickness
    CommonBall ball{};   ///< if both parts are closed and overlap: the largest ball in the overlap
    bool has_ball = false;
    bool tolerated = false;  ///< touching: the parts overlap, or are apart, by no more than the tolerance
    bool overlapped = false; ///< tolerated: they overlap
    double deflection = 0;   ///< twice the larger deflection of both parts: a common ball of a larger diameter, or a
                             ///< larger gap, is certainly there
    double lower = 0, upper = 0; ///< certified bounds on the distance of parts that are apart; else 0
    Eigen::Vector3d where =
        Eigen::Vector3d::Zero(); ///< the centre of the overlap; apart: midway between the nearest points
    Eigen::Vector3d nearest_a = Eigen::Vector3d::Zero(), nearest_b = Eigen::Vector3d::Zero(); ///< apart
    ClashStatus status = ClashStatus::fresh;
    std::string was{};     ///< the kind in the baseline, if less severe
    std::string review{};  ///< a status that a user wrote into the baseline, such as "approved"; only if active
    std::string comment{}; ///< from the baseline

    bool apart() const { return upper > 0; }
    bool overlaps() const { return kind < ClashKind::within; }
    /// The status in reports.
    std::string_view status_text() const { return review.empty() ? name_of(status) : std::string_view(review); }
    bool has_volume() const { return has_ball && std::isfinite(ball.volume_upper); }
    double ball_lower() const { return 2 * ball.radius_lower; } ///< bounds of the ball's diameter
    double ball_upper() const { return 2 * ball.radius_upper; }
    /// Sorting key: the diameter of the ball; below 0 for parts that are not closed, the longer their contact curve the
    /// less.
    double severity() const;
};

constexpr double tolerance_of_files = -1;
class ClashMatrix;

struct ClashSettings {
    double clearance = 0; ///< parts closer than this are near
    /// Parts touch if they are apart by no more than this, or if their overlap certainly holds no ball of this
    /// diameter.
    double tolerance = 0;
    bool from_files = false;              ///< mend() took the tolerance from the files
    bool touching = false;                ///< touching is a clash
    bool self = false;                    ///< also find the parts that meet themselves
    const ClashMatrix* matrix = nullptr;  ///< other limits for some pairs; null: none
    std::uint64_t most_pairs = 2'000'000; ///< most pairs of parts whose AABBs overlap
    int threads = 0;
};

/// A part whose triangles meet each other.
struct PartMeetsItself {
    std::uint32_t part;
    std::size_t pairs;                  ///< of triangles
    std::array<std::uint32_t, 2> worst; ///< triangles of one pair, where most pairs are connected
    Eigen::Vector3d where;              ///< the middle of these pairs
};

/// A World that holds the parts, and the pairs of parts that are too close, the most severe first.
struct Clashes {
    std::unique_ptr<World> world;
    std::vector<BodyId> bodies; ///< by part
    std::vector<Clash> list;
    std::vector<std::uint8_t> closed;  ///< by part
    std::vector<std::uint32_t> open;   ///< parts that are not closed: parts inside them are not found
    std::vector<PartMeetsItself> self; ///< if requested
    std::size_t pairs = 0;             ///< number of pairs whose AABBs overlap
    std::size_t skipped = 0;           ///< pairs at most the largest clearance apart that the matrix skips

    PairOfBodies pair(const Clash& clash) const { return {bodies[clash.a], bodies[clash.b]}; }
};

/// Gives settings of `tolerance_of_files` the precision of the files as tolerance, and closes the parts' meshes within
/// an eighth of the tolerance and of this precision, so that no part moves by half the tolerance. A tolerance of 0
/// leaves the parts as they are. Cost: as mend_parts().
void mend(PartList& parts, ClashSettings& settings);
/// The settings that decide pairs.
/// @param deflection  most that the meshes of a pair deviate from the true surfaces, together
Settings settings_of(const ClashSettings& settings, double deflection = 0);
/// The layers of a part: parts are compared if each is on a layer in the other's mask.
struct PartLayers {
    std::uint32_t layer = 1, mask = 0xffffffffu;
};
PartLayers layers_of(const PartList& list, const Part& part);

/// Decides all pairs of parts of different groups, exactly; with sets, only pairs of a part of A and a part of B. Pairs
/// below their deflections are within. Throws Error{bad_data} for more than settings.most_pairs.
Clashes find_clashes(const PartList& parts, const ClashSettings& settings);

/// True if `a` is listed before `b`: overlaps, the largest ball first; parts that touch; near ones, the nearest first.
bool more_severe(const Clash& a, const Clash& b);

} // namespace oncollide::tools
