#include <oncollide/narrowphase/shapes/convex_meeting.hpp>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <oncollide/narrowphase/shapes/convex_distance.hpp>
#include <oncollide/narrowphase/shapes/newton_meeting.hpp>
#include <oncollide/narrowphase/shapes/simplex.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

class Portal {
public:
    /// @param looks  evaluations whose points become the first corners
    Portal(const ConvexDifference& cores, const NewtonMeeting& looks)
        : cores_(cores), looks_(looks), rounding_(cores.rounding()), inside_(cores.middle()), inner_(cores.inner()),
          smooth_(!cores.flat_sided())
    {
    }

    ConvexMeeting find()
    {
        if (inside_.norm() + rounding_ < inner_) return {-1, 0};
        corner_[0] = looks_.first, normal_[0] = -inside_ / inside_.norm();
        if (met_on_segment()) return {-1, 0};
        corner_[1] = looks_.last, normal_[1] = -looks_.direction;
        Vector3d n = normal(inside_, 0, 1);
        if (looks_.looks == 1 || !(n.norm() > 0x1p-30 * inside_.norm() * (corner_[1].w - corner_[0].w).norm())) {
            n = corner_[0].w.cross(inside_);
            // 0, the point inside and the first corner are on one line: use any plane through it.
            if (!(n.norm() > 0x1p-40 * inside_.norm() * corner_[0].w.norm()))
                n = inside_.unitOrthogonal() * inside_.norm();
            if (!look(n, 1)) return {1, bound_};
            n = normal(inside_, 0, 1);
        }
        if (n.dot(inside_) > 0) std::swap(corner_[0], corner_[1]), std::swap(normal_[0], normal_[1]), n = -n;
        return refine(n);
    }

private:
    Vector3d normal(const Vector3d& from, int i, int j) const
    {
        return (corner_[i].w - from).cross(corner_[j].w - from);
    }
    /// Sets corner i to the support point along d. False: the difference certainly does not extend to 0 along d.
    bool look(const Vector3d& d, int i)
    {
        corner_[i] = cores_.support(d);
        if (smooth_) normal_[i] = d / d.norm();
        const double along = d.dot(corner_[i].w);
        if (!(along < 0)) return true;
        bound_ = -along / d.norm() - rounding_;
        return !(bound_ > 0);
    }
    void move_corner(int from, int to) { corner_[to] = corner_[from], normal_[to] = normal_[from]; }
    /// The approximate normal of a smooth surface where the ray passes the portal, mixed from the normals at the
    /// corners.
    Vector3d mixed_normal() const
    {
        const Vector3d a = corner_[0].w.cross(inside_), b = corner_[1].w.cross(inside_);
        const double of_2 = std::abs(a.dot(corner_[1].w)), of_1 = std::abs(a.dot(corner_[2].w)),
                     of_0 = std::abs(b.dot(corner_[2].w));
        return of_0 * normal_[0] + of_1 * normal_[1] + of_2 * normal_[2];
    }
    /// True if 0 is certainly a convex combination of the first corner and the sphere around the point inside.
    bool met_on_segment() const
    {
        const Vector3d d = corner_[0].w - inside_;
        const double t = std::clamp(-inside_.dot(d) / d.squaredNorm(), 0.0, 1.0);
        return (inside_ + t * d).norm() + rounding_ < (1 - t) * inner_;
    }
    /// True if 0 is certainly a convex combination of the corners and the sphere around the point inside.
    bool met() const
    {
        const Vector3d p = corner_[0].w - inside_, q = corner_[1].w - inside_, r = corner_[2].w - inside_;
        const Vector3d by_volume[3] = {q.cross(r), r.cross(p), p.cross(q)};
        const double volume = p.dot(by_volume[0]);
        if (!(volume != 0)) return false;
        double share[4] = {1, 0, 0, 0};
        const auto mixed = [&]() -> Vector3d {
            return share[0] * inside_ + share[1] * corner_[0].w + share[2] * corner_[1].w + share[3] * corner_[2].w;
        };
        Vector3d rest = inside_;
        for (int round = 0; round < 3 && rest.norm() > rounding_; ++round) { // a thin portal takes more than one round
            for (int k = 0; k < 3; ++k) {
                const double more = -rest.dot(by_volume[k]) / volume;
                share[k + 1] += more, share[0] -= more;
            }
            rest = mixed();
        }
        double sum = 0;
        for (double& s : share) s = std::max(s, 0.0), sum += s;
        return mixed().norm() / sum + 2 * rounding_ < share[0] / sum * inner_;
    }
    /// Adds corners along n until the ray passes between three of them; then moves the portal outward.
    ConvexMeeting refine(Vector3d n)
    {
        constexpr int most_steps = 128;
        for (int step = 0;; ++step) {
            if (!look(n, 2)) return {1, bound_};
            if (step == most_steps) return open();
            if (corner_[0].w.cross(corner_[2].w).dot(inside_) < 0)
                move_corner(2, 1);
            else if (corner_[2].w.cross(corner_[1].w).dot(inside_) < 0)
                move_corner(2, 0);
            else
                break;
            n = normal(inside_, 0, 1);
        }
        for (int step = 0; step < most_steps; ++step) {
            n = normal(corner_[0].w, 1, 2);
            const double length = n.norm(), height = n.dot(corner_[0].w) / length;
            if (!(length > 0)) break;
            if (height >= 0 && met()) return {-1, 0};
            // Mixed normals soon find smooth surfaces; other surfaces may have no point beyond the portal there.
            bool beyond = false;
            if (smooth_ && step % 3 == 0) {
                if (!look(mixed_normal(), 3)) return {1, bound_};
                beyond = corner_[3].w.dot(n) / length - height > rounding_;
            }
            if (!beyond) {
                if (!look(n, 3)) return {1, bound_};
                if (corner_[3].w.dot(n) / length - height <= rounding_) break;
            }
            // The new corner makes three portals with two of the old corners each; keep the portal that the ray passes.
            const Vector3d across = corner_[3].w.cross(inside_);
            if (across.dot(corner_[0].w) > 0)
                move_corner(3, across.dot(corner_[1].w) > 0 ? 0 : 2);
            else
                move_corner(3, across.dot(corner_[2].w) > 0 ? 1 : 0);
        }
        return open();
    }
    ConvexMeeting open() const
    {
        Simplex4 simplex;
        for (simplex.count = 0; simplex.count < 3; ++simplex.count)
            simplex.corner[simplex.count] = corner_[simplex.count];
        simplex.corner[simplex.count++] = {inside_, Vector3d::Zero()};
        simplex.reduce();
        return {0, simplex.nearest().norm() + rounding_};
    }

    const ConvexDifference& cores_;
    const NewtonMeeting& looks_;
    const double rounding_;
    const Vector3d inside_;
    const double inner_;
    const bool smooth_;
    std::array<ConvexDifference::Point, 4> corner_; ///< three corners of the portal, and a new one
    std::array<Vector3d, 4> normal_;                ///< unit directions whose support points the corners are
    double bound_ = 0;
};

/// Decides about an ellipsoid, E, and another solid, in a frame that scales E's axes to 1, where E is a sphere.
/// @param off  error bound of the other solid's points, besides rounding
ConvexMeeting meeting_with_ball(const Convex& e, const Convex& other, const RelativePose& other_to_e, double off)
{
    const Vector3d shrink = e.high.cwiseInverse();
    const double most = shrink.maxCoeff();
    RelativePose into_ball = other_to_e;
    into_ball.rotation = shrink.asDiagonal() * other_to_e.rotation;
    into_ball.translation = shrink.cwiseProduct(other_to_e.translation);
    Convex ball, shrunk = other;
    ball.low = ball.high = ball.centre = Vector3d::Zero(), ball.radius = 1;
    shrunk.extent *= most;
    const ConvexDifference cores(ball, shrunk, into_ball, 0);
    const double rounding = off * most * (1 + 0x1p-40);
    const ConvexDistance d = convex_distance(cores, {.cutoff = 1 + rounding, .below = 1 - rounding});
    if (d.lower > 1 + rounding) return {1, (d.lower - 1 - rounding) / most * (1 - 0x1p-40)};
    return {d.upper <= 1 - rounding ? -1 : 0, 0};
}

ConvexMeeting meeting_with_ball(const ConvexDifference& cores)
{
    const double rounding = 2 * cores.rounding();
    if (cores.a().core == Convex::Core::ellipsoid)
        return meeting_with_ball(cores.a(), cores.b(), cores.b_to_a(), rounding);
    // A point of A errs in B's frame by the rotation's deviation from rigid.
    RelativePose back = cores.b_to_a();
    back.rotation.transposeInPlace();
    back.translation = -(back.rotation * cores.b_to_a().translation);
    return meeting_with_ball(cores.b(), cores.a(), back,
                             rounding + 2 * cores.slack() * (cores.size() + back.translation.norm()));
}

} // namespace

ConvexMeeting convex_meeting(const ConvexDifference& cores)
{
    if (const double least = cores.least(); least > 0) return {1, least};
    const NewtonMeeting looks = newton_meeting(cores);
    if (looks.meeting.sign != 0) return looks.meeting;
    if (cores.a().core == Convex::Core::ellipsoid || cores.b().core == Convex::Core::ellipsoid)
        if (const ConvexMeeting found = meeting_with_ball(cores); found.sign != 0) return found;
    return Portal(cores, looks).find();
}

} // namespace oncollide
