#include <oncollide/narrowphase/overlap/common_ball.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/overlap/facing_bound.hpp>
#include <oncollide/narrowphase/overlap/local_sides.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

constexpr double any_depth = std::numeric_limits<double>::infinity();

/// How many times the box's reach the balls are in which faces are looked at: a small ball has few faces, and in a
/// large one a point of the box is farther from the ball's surface.
constexpr double close = 1.25, wide = 2.5;

/// A box with the faces near it.
struct BoxPart {
    Aabb box;
    Vector3d point = Vector3d::Zero(); ///< near its middle, on no face
    double reach = 0;                  ///< largest distance of the box's points from `point`
    double seen = any_depth;           ///< all faces within this distance of `point` are near
    double most = any_depth;           ///< upper bound on the depth below both surfaces
    struct Surface {
        std::vector<std::uint32_t> near; ///< the faces within `seen` of the point, and all faces that may be the
                                         ///< nearest to a point of the box
        int winding = 0;
        double distance = any_depth; ///< of the point
        double depth() const { return winding ? distance : -distance; }
    };
    std::array<Surface, 2> surfaces;

    double depth() const { return std::min(surfaces[0].depth(), surfaces[1].depth()); }
    double volume() const { return (box.max - box.min).prod(); }
};

class BallSearch {
public:
    BallSearch(const PlacedFaces& a, const PlacedFaces& b, const Aabb& box, double slack,
               const CommonBallOptions& options)
        : solids_{&a, &b}, options_(options), slack_(slack)
    {
        root_.box = box;
        for (std::size_t s = 0; s < 2; ++s) {
            root_.surfaces[s].near.resize(solids_[s]->faces().size());
            for (std::uint32_t k = 0; k < root_.surfaces[s].near.size(); ++k) root_.surfaces[s].near[k] = k;
        }
    }

    void find_ball(CommonBall& found)
    {
        std::optional<BoxPart> first = half_of(root_, nullptr);
        if (!first) return; // the middle cannot be located: nothing is known
        double dropped = 0;
        const auto threshold = [&] { return std::max(options_.enough, (1 + options_.relative) * found.radius_lower); };
        const auto less = [](const BoxPart& p, const BoxPart& q) { return p.most < q.most; };
        std::vector<BoxPart> open;
        const auto keep = [&](BoxPart part) {
            const auto take = [&](double depth, const Vector3d& point) {
                if (depth - slack_ > found.radius_lower) found.radius_lower = depth - slack_, found.centre = point;
            };
            take(part.depth(), part.point);
            part.most = std::min(part.most, part.depth() + part.reach + slack_);
            if (part.most > threshold()) part.most = std::min(part.most, facing_bound(part, threshold()));
            if (part.most > threshold()) {
                Vector3d deep = Vector3d::Zero();
                part.most = std::min(part.most, bound(part, threshold(), deep));
                if (part.most > found.radius_lower && !deep.isZero())
                    take(depth_at(part, part.point + deep), part.point + deep);
            }
            if (part.most <= threshold()) {
                dropped = std::max(dropped, part.most);
                return;
            }
            open.push_back(std::move(part));
            std::ranges::push_heap(open, less);
        };
        keep(std::move(*first));
        for (int boxes = 1; !open.empty() && open.front().most > threshold(); boxes += 2) {
            if (boxes >= options_.most_boxes) break;
            std::ranges::pop_heap(open, less);
            const BoxPart part = std::move(open.back());
            open.pop_back();
            for (const Aabb& box : halves(part.box)) {
                if (auto half = half_of(part, &box)) {
                    half->most = part.most;
                    keep(std::move(*half));
                } else
                    dropped = std::max(dropped, part.most);
            }
        }
        centre(found);
        found.radius_upper = std::max({found.radius_lower, dropped, open.empty() ? 0 : open.front().most});
    }

    void find_volume(CommonBall& found)
    {
        std::optional<BoxPart> first = half_of(root_, nullptr);
        if (!first) return;
        // A box has between `sure` and `sure + gap` inside both.
        struct Open {
            BoxPart part;
            double sure, gap;
            bool operator<(const Open& other) const { return gap < other.gap; }
        };
        std::vector<Open> open;
        double sure = 0, gap = 0;
        const auto keep = [&](BoxPart part) {
            if (part.depth() + slack_ < -part.reach) return;
            const double whole = part.volume();
            Open entry{{}, 0, whole};
            if (part.depth() - slack_ > part.reach) {
                entry = {{}, whole, 0};
            } else if (set_sides(part, close * part.reach)) {
                const auto [least, most] =
                    LocalSides::volume(sides_[0], sides_[1], {part.box.min - part.point, part.box.max - part.point});
                const double rounding = 0x1p-40 * whole + slack_ * std::pow(part.reach, 2);
                entry = {{}, std::max(0.0, least - rounding), 0};
                entry.gap = std::min(whole, most + rounding) - entry.sure;
            }
            sure += entry.sure, gap += entry.gap;
            entry.part = std::move(part);
            open.push_back(std::move(entry));
            std::push_heap(open.begin(), open.end());
        };
        keep(std::move(*first));
        double lost = 0;
        for (int boxes = 1; !open.empty() && boxes < options_.most_boxes_for_volume; boxes += 2) {
            if (gap + lost <= options_.relative_volume * sure) break;
            std::pop_heap(open.begin(), open.end());
            const Open whole = std::move(open.back());
            open.pop_back();
            sure -= whole.sure, gap -= whole.gap;
            for (const Aabb& box : halves(whole.part.box))
                if (auto half = half_of(whole.part, &box))
                    keep(std::move(*half));
                else
                    lost += whole.part.volume() / 2;
        }
        sure = 0, gap = lost; // once more, without the rounding of many differences
        for (const Open& entry : open) sure += entry.sure, gap += entry.gap;
        found.volume_lower = sure * (1 - 0x1p-30), found.volume_upper = (sure + gap) * (1 + 0x1p-30);
    }

private:
    static std::array<Aabb, 2> halves(const Aabb& box)
    {
        std::array<Aabb, 2> two{box, box};
        Eigen::Index axis = 0;
        (box.max - box.min).maxCoeff(&axis);
        two[0].max[axis] = two[1].min[axis] = box.centre()[axis];
        return two;
    }

    /// The part of `whole` in a box; without a box all of it, a root whose faces are all near and of unknown winding.
    /// None if every point that was tried near its middle is on a face or an edge.
    std::optional<BoxPart> half_of(const BoxPart& whole, const Aabb* box)
    {
        BoxPart part;
        part.box = box ? *box : whole.box;
        const Vector3d middle = part.box.centre(), half = part.box.half_extent();
        for (std::uint64_t attempt = 0;; ++attempt) {
            if (attempt == 16) return {};
            // Not the middle itself: it would often lie on a face of a model that was drawn on a grid.
            for (std::uint64_t k = 0; k < 3; ++k)
                part.point[int(k)] = middle[int(k)] + 0.1 * half[int(k)] * (u01(3, attempt, k) - 0.5);
            bool located = true;
            for (std::size_t s = 0; s < 2 && located; ++s) {
                const auto& above = whole.surfaces[s];
                const auto winding = box ? solids_[s]->winding_change(whole.point, part.point, above.near)
                                         : solids_[s]->winding(part.point);
                located = winding.has_value();
                if (located) part.surfaces[s].winding = (box ? above.winding : 0) + *winding;
            }
            if (located) break;
        }
        part.reach = (half + (part.point - middle).cwiseAbs()).norm() + slack_;
        part.seen = wide * part.reach; // and no more than is known of the whole
        if (box) part.seen = std::min(part.seen, whole.seen - (part.point - whole.point).norm() - slack_);
        for (std::size_t s = 0; s < 2; ++s) gather(whole.surfaces[s].near, s, part);
        return part;
    }

    void gather(const std::vector<std::uint32_t>& faces, std::size_t s, BoxPart& part)
    {
        BoxPart::Surface& surface = part.surfaces[s];
        const std::span<const PlacedFaces::Face> all = solids_[s]->faces();
        // Most faces are certainly too far away: the middle of the nearest face is nearer.
        middles_.clear(), ways_[s].clear();
        double nearest = any_depth;
        for (const std::uint32_t face : faces) {
            middles_.push_back((part.point - all[face].middle).norm());
            nearest = std::min(nearest, middles_.back());
        }
        const double farthest = std::max(nearest + 2 * part.reach, part.seen) + 3 * slack_;
        for (std::size_t k = 0; k < faces.size(); ++k) {
            if (middles_[k] - all[faces[k]].radius > farthest) continue;
            surface.near.push_back(faces[k]);
            ways_[s].push_back(way_to(all[faces[k]].corners, part.point));
            surface.distance = std::min(surface.distance, ways_[s].back().norm());
        }
        const double far = std::max(surface.distance + 2 * part.reach, part.seen) + slack_;
        std::size_t kept = 0;
        for (std::size_t k = 0; k < ways_[s].size(); ++k)
            if (ways_[s][k].norm() <= far) surface.near[kept] = surface.near[k], ways_[s][kept++] = ways_[s][k];
        surface.near.resize(kept), ways_[s].resize(kept);
    }

    /// A bound on the depth in the part for which gather() was called last.
    double facing_bound(const BoxPart& part, double enough)
    {
        facing_.clear();
        for (std::size_t s = 0; s < 2; ++s)
            for (std::size_t k = 0; k < ways_[s].size(); ++k)
                facing_.add(solids_[s]->faces()[part.surfaces[s].near[k]], ways_[s][k]);
        return facing_.find(part.box, part.reach, enough) + slack_;
    }

    /// The depth of a point; negative outside, and if it is not known.
    double depth_at(const BoxPart& part, const Vector3d& point) const
    {
        if (!(point.array() >= part.box.min.array() && point.array() <= part.box.max.array()).all()) return -1;
        double depth = any_depth;
        for (std::size_t s = 0; s < 2; ++s) {
            const BoxPart::Surface& surface = part.surfaces[s];
            const auto change = solids_[s]->winding_change(part.point, point, surface.near);
            if (!change || surface.winding + *change == 0) return -1;
            for (const std::uint32_t face : surface.near)
                depth = std::min(depth, distance_of(point, solids_[s]->faces()[face].corners));
        }
        return depth;
    }

    /// Moves the ball to where it may be larger: between the faces that face each other around it, and by small steps
    /// along the axes.
    void centre(CommonBall& found)
    {
        if (!(found.radius_lower > 0)) return;
        BoxPart around;
        const double half = 1.2 * found.radius_lower;
        around.box = {found.centre.array() - half, found.centre.array() + half};
        around.point = found.centre, around.reach = std::sqrt(3.0) * half, around.seen = wide * around.reach;
        for (std::size_t s = 0; s < 2; ++s) {
            const auto winding = solids_[s]->winding(around.point);
            if (!winding) return;
            around.surfaces[s].winding = *winding;
            gather(root_.surfaces[s].near, s, around);
        }
        const auto try_at = [&](const Vector3d& point) {
            const double depth = depth_at(around, point) - slack_;
            const bool deeper = depth > found.radius_lower;
            if (deeper) found.radius_lower = depth, found.centre = point;
            return deeper;
        };
        Vector3d deep = Vector3d::Zero();
        if (set_sides(around, 1.6 * found.radius_lower))
            LocalSides::depth(sides_[0], sides_[1], found.radius_lower / 2, deep);
        if (!deep.isZero()) try_at(around.point + deep);
        for (const double share : {0.1, 0.03, 0.01, 0.003}) {
            const double step = share * found.radius_lower;
            for (const int axis : {0, 1, 2})
                for (const double way : {-step, step})
                    while (try_at(found.centre + way * Vector3d::Unit(axis))) {}
        }
    }

    /// A bound on the depth by the planes of the faces near the part; infinite if there are too many.
    /// @param enough  no need to find a lower one
    /// @param deep    set to a point of the box that may be deep
    double bound(const BoxPart& part, double enough, Vector3d& deep)
    {
        double least = any_depth;
        for (const double times : {close, wide}) {
            if (set_sides(part, std::min(times * part.reach, part.seen)))
                least = std::min(least, LocalSides::depth(sides_[0], sides_[1], part.reach, deep) + 4 * slack_);
            if (least <= enough) break;
        }
        return least;
    }

    /// False if many planes pass through the ball, or if it may have faces that are not near.
    bool set_sides(const BoxPart& part, double radius)
    {
        if (radius > part.seen) return false;
        for (std::size_t s = 0; s < 2; ++s) {
            const BoxPart::Surface& surface = part.surfaces[s];
            close_.clear();
            for (const std::uint32_t face : surface.near)
                if (distance_of(part.point, solids_[s]->faces()[face].corners) <= radius + slack_)
                    close_.push_back(face);
            const double thick = std::max(8 * slack_, options_.enough / 4);
            if (!sides_[s].set(*solids_[s], close_, part.point, radius, thick, surface.winding)) return false;
        }
        return true;
    }

    std::array<const PlacedFaces*, 2> solids_;
    CommonBallOptions options_;
    double slack_; ///< rounding of coordinates and distances, more than enough
    BoxPart root_;
    std::array<LocalSides, 2> sides_;
    std::vector<double> middles_;
    std::array<std::vector<Vector3d>, 2> ways_; ///< of gather(): from the point to the near faces
    FacingBound facing_;
    std::vector<std::uint32_t> close_;
};

} // namespace

CommonBall common_ball(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b,
                       const CommonBallOptions& options)
{
    const auto placed = [](const Mesh& mesh, const Eigen::Isometry3d& pose) {
        Aabb box;
        for (const Vector3d& vertex : mesh.vertices) box.add(pose * vertex);
        return box;
    };
    const Aabb box_a = placed(a, pose_a), box_b = placed(b, pose_b);
    Aabb box{box_a.min.cwiseMax(box_b.min), box_a.max.cwiseMin(box_b.max)};
    CommonBall found;
    if ((box.min.array() > box.max.array()).any()) {
        found.radius_upper = found.volume_upper = 0;
        return found;
    }
    double largest = 0;
    for (const Aabb& bounds : {box_a, box_b})
        largest = std::max({largest, bounds.min.cwiseAbs().maxCoeff(), bounds.max.cwiseAbs().maxCoeff()});
    const double slack = 0x1p-46 * largest;
    const Vector3d origin = box.centre();
    box.min = (box.min - origin).array() - slack, box.max = (box.max - origin).array() + slack;
    const PlacedFaces faces_a(a, pose_a, origin), faces_b(b, pose_b, origin);
    BallSearch search(faces_a, faces_b, box, slack, options);
    search.find_ball(found);
    if (options.most_boxes_for_volume > 0 && found.radius_upper > options.enough) search.find_volume(found);
    found.centre += origin;
    return found;
}

} // namespace oncollide
