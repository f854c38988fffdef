#include <oncollide/broadphase/bounds/pose_bounds.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/base/error.hpp>
#include <oncollide/base/rigid.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/broadphase/aabb_kernel.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/model/mesh_topology.hpp>

namespace oncollide {

const AabbKernel& aabb_kernel()
{
    static const AabbKernel kernel = ONCOLLIDE_CHOOSE(aabb_kernel);
    return kernel;
}

namespace {

// Refining the rest of a map costs about as much as using the unrefined map for this many more boxes.
constexpr std::uint64_t boxes_that_complete_a_map = 4096;
constexpr std::size_t fewest_points_of_a_map = 256;
constexpr std::size_t most_read_at_once = 8; ///< chunks of a cooked mesh; from a larger mesh, only the chunks at its
                                             ///< ends are read

Aabb around(const Eigen::Vector3d& centre, const Eigen::Vector3d& half)
{
    // Far from the origin, the sums below round by at most this much.
    const Eigen::Vector3d h = half + Eigen::Vector3d::Constant(1e-15 * (centre.lpNorm<Eigen::Infinity>() + half.sum()));
    ONCOLLIDE_ASSERT((h.array() >= 0).all());
    Aabb box;
    box.min = centre - h, box.max = centre + h;
    return box;
}

/// Error bound for a transformed centre and for poses relative to other bodies: a rotated centre and a translation may
/// cancel, and matrices in double are within 2^-52 of rotations.
double rounding_of(const Eigen::Isometry3d& pose, const Eigen::Vector3d& centre)
{
    return 0x1p-49 * (centre.lpNorm<1>() + pose.translation().lpNorm<Eigen::Infinity>());
}

/// Half-extents of the box of a shape whose axis-aligned frame is rotated by `r`.
struct RotatedHalf {
    const Eigen::Matrix3d& r;
    Eigen::Vector3d operator()(const Sphere& s) const { return Eigen::Vector3d::Constant(s.radius); }
    Eigen::Vector3d operator()(const Box& b) const { return r.cwiseAbs() * b.half; }
    Eigen::Vector3d operator()(const Capsule& c) const
    {
        return r.col(2).cwiseAbs() * (0.5 * c.length) + Eigen::Vector3d::Constant(c.radius);
    }
    Eigen::Vector3d operator()(const Cylinder& c) const
    {
        // Does not use the root of 1 - z^2: for a cylinder that leans by 1e-9, that difference is only rounding.
        const Eigen::Vector3d across = r.leftCols<2>().rowwise().norm() * (1 + 1e-15);
        return r.col(2).cwiseAbs() * (0.5 * c.length) + across * c.radius;
    }
    Eigen::Vector3d operator()(const ConvexHull&) const { return {}; } // not called: has points
    Eigen::Vector3d operator()(const Ellipsoid& e) const
    {
        return (r.array().square().matrix() * e.semi_axes.array().square().matrix()).cwiseSqrt() * (1 + 1e-15);
    }
    Eigen::Vector3d operator()(const Cone&) const { return {}; }      // not called: its box is not centred
    Eigen::Vector3d operator()(const HalfSpace&) const { return {}; } // not called: is unbounded
};

/// The box of a cone's apex and base, relative to its centre.
Aabb cone_box(const Cone& cone, const Eigen::Matrix3d& r)
{
    const Eigen::Vector3d apex = 0.5 * cone.length * r.col(2), disc = RotatedHalf{r}(Cylinder{cone.radius, 0});
    return {apex.cwiseMin(-apex - disc), apex.cwiseMax(-apex + disc)};
}

/// The box of a half-space: all of space, except the outside of one whose normal is along an axis.
Aabb half_space_box(const Eigen::Isometry3d& pose)
{
    constexpr double end = half_space_end;
    Aabb box{Eigen::Vector3d::Constant(-end), Eigen::Vector3d::Constant(end)};
    const Eigen::Vector3d normal = pose.linear().col(2), at = pose.translation();
    for (int axis = 0; axis < 3; ++axis) {
        if (normal[(axis + 1) % 3] != 0 || normal[(axis + 2) % 3] != 0) continue;
        (normal[axis] > 0 ? box.max : box.min)[axis] = at[axis];
    }
    return box;
}

/// The vertices that determine a geometry's box; null if it has a closed form or no vertices in memory.
const std::vector<Eigen::Vector3d>* points_of(const GeometryData& geometry)
{
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) return &mesh->vertices;
    if (const auto* shape = std::get_if<Shape>(&geometry))
        if (const auto* hull = std::get_if<ConvexHull>(shape)) return &hull->points;
    return nullptr;
}

/// True if the rotation maps axes to axes, so the box of the rotated bounds is tight.
bool turns_by_quarters(const Eigen::Matrix3d& r)
{
    return (r.array() == 0 || r.array().abs() == 1).all();
}

} // namespace

PoseBounds::PoseBounds(const GeometryData& geometry) : geometry_(geometry)
{
    set_size();
}

void PoseBounds::set_size()
{
    const Aabb bounds = bounds_of(geometry_);
    ONCOLLIDE_ASSERT(!bounds.empty());
    centre_ = bounds.centre(), half_ = bounds.half_extent();
    radius_ = bounds.half_extent().norm() * (1 + 1e-15);
    slack_ = 1e-15 * (radius_ + centre_.norm());
}

void PoseBounds::deform()
{
    const Mesh* const mesh = std::get_if<Mesh>(&geometry_);
    if (mesh && moves_ == Moves::none) {
        const std::vector<bool> used = used_vertices(*mesh);
        moves_ = std::ranges::find(used, false) == used.end() ? Moves::all_used : Moves::some_used;
    }
    set_size();
    support_ = {}, requested_ = 0, final_ = false;
}

void PoseBounds::copy_moved_points()
{
    const Mesh& mesh = std::get<Mesh>(geometry_);
    if (moves_ == Moves::all_used)
        set_columns(points_, mesh.vertices, centre_);
    else
        points_ = used_points(mesh, centre_);
    final_ = true;
}

void PoseBounds::expect(const Eigen::Isometry3d& pose)
{
    ONCOLLIDE_ASSERT(why_not_rigid(pose).empty());
    const std::vector<Eigen::Vector3d>* points = points_of(geometry_);
    const auto* cooked = std::get_if<std::shared_ptr<const CookedMesh>>(&geometry_);
    if (!points && !cooked) final_ = true;
    if (final_ || turns_by_quarters(pose.linear())) return;
    if (cooked && expect(*cooked, pose)) return;
    if (++requested_ == 1) {
        if (moves_ != Moves::none) return copy_moved_points();
        const auto* mesh = std::get_if<Mesh>(&geometry_);
        try {
            points_ = mesh     ? used_points(*mesh, centre_)
                      : cooked ? used_points((*cooked)->whole(), centre_)
                               : point_columns(*points, centre_);
        } catch (const ChunkFault&) { // recorded by CookedMesh; the box of the rotated bounds stays in use
            final_ = true, requested_ = 0;
            return;
        }
        final_ = points_.size() < fewest_points_of_a_map;
        if (!final_) support_ = SupportMap(std::move(points_)), points_ = {};
    }
    if (final_) return;
    if (requested_ % SupportMap::boxes_a_look == 0) support_.prepare(pose.linear().cast<float>());
    final_ = requested_ >= boxes_that_complete_a_map;
    if (final_) support_.complete();
}

/// Returns false if the mesh should be read as a whole.
bool PoseBounds::expect(const std::shared_ptr<const CookedMesh>& mesh, const Eigen::Isometry3d& pose)
{
    try {
        if (!cooked_) {
            if (points_.size() > 0 || !support_.empty() || mesh->open()->tree_chunks <= most_read_at_once) return false;
            cooked_ = std::make_unique<CookedSupport>(mesh, centre_);
        }
        const Eigen::Matrix3f rows = pose.linear().cast<float>();
        for (int axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3f row = rows.row(axis);
            cooked_->prepare(row), cooked_->prepare(-row);
        }
        requested_ = 1;
    } catch (const ChunkFault&) { // recorded by CookedMesh; the box of the rotated bounds stays in use
        final_ = true;
    }
    return true;
}

namespace {

/// The part of a motion until its next key, in steps of an eighth of a radian at most.
struct Steps {
    Steps(const RigidMotion& motion, double from) : state(motion.at(from)), begin(from), end(state.key)
    {
        constexpr double most_turn = 0.125; // rad
        angle = state.angular.norm() * (end - begin);
        count = std::max(1, static_cast<int>(std::ceil(angle / most_turn)));
    }
    /// The end of step k, from 1.
    double time(int k) const { return k == count ? end : begin + (end - begin) * k / count; }

    RigidMotion::State state;
    double begin, end, angle;
    int count;
};

} // namespace

bool PoseBounds::is_half_space() const
{
    const auto* shape = std::get_if<Shape>(&geometry_);
    return shape && std::holds_alternative<HalfSpace>(*shape);
}

void PoseBounds::expect(const RigidMotion& motion)
{
    expect(motion.pose(0));
    for (double begin = 0; begin < 1 && !final_;) {
        const Steps steps(motion, begin);
        for (int k = 1; k <= steps.count; ++k) expect(motion.pose(steps.time(k)));
        begin = steps.end;
    }
}

Aabb PoseBounds::box(const RigidMotion& motion, bool tight) const
{
    const auto at = [&](double time) { return tight ? box(motion.pose(time)) : sphere_box(motion.pose(time)); };
    Aabb here = at(0), all = here;
    for (double begin = 0; begin < 1;) {
        const Steps steps(motion, begin);
        if (is_half_space() && steps.angle > 0) {
            all.min.setConstant(-half_space_end), all.max.setConstant(half_space_end);
            return all;
        }
        Aabb of_piece = here;
        for (int k = 1; k <= steps.count; ++k) of_piece.add(here = at(steps.time(k)));
        const double out = bulge(steps.state, (steps.end - begin) / steps.count);
        of_piece.min.array() -= out, of_piece.max.array() += out;
        all.add(of_piece);
        begin = steps.end;
    }
    return all;
}

double PoseBounds::motion(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) const
{
    const Eigen::Matrix3d turn = to.linear() - from.linear();
    const double shift = (to.translation() - from.translation() + turn * centre_).norm(), norm = turn.norm();
    if (norm == 0) return shift * (1 + 0x1p-18);
    // For a difference of two rotations, the norm is sqrt 2 times the displacement 2 sin(angle / 2) of a point 1 m from
    // the axis. Poses are within 2^-20 of rotations.
    const double around = radius_ * std::min(norm, 0.70710678118654757 * norm + 0x1p-18);
    const auto off = [](const Eigen::Matrix3d& r) { return (r.transpose() * r - Eigen::Matrix3d::Identity()).norm(); };
    return (shift + around + (off(from.linear()) + off(to.linear())) * reach()) * (1 + 0x1p-18);
}

double PoseBounds::bulge(const RigidMotion::State& state, double duration) const
{
    const double spin = state.angular.norm(), angle = spin * duration;
    const double off_axis =
        spin > 0 ? state.angular.cross(state.pose * centre_ - state.pivot).norm() / spin + radius_ : 0;
    return (0.125 * angle * angle * off_axis + 2 * state.position_error +
            2 * state.rotation_error * (centre_.norm() + radius_)) *
           (1 + 0x1p-18);
}

double PoseBounds::motion(const Eigen::Isometry3d& from, const RigidMotion& motion) const
{
    return this->motion(from, motion.pose(0)) + motion.travel(0, 1, centre_, radius_);
}

Aabb PoseBounds::box(const Eigen::Isometry3d& pose) const
{
    ONCOLLIDE_ASSERT(pose.matrix().allFinite());
    if (is_half_space()) return half_space_box(pose);
    const auto* shape = std::get_if<Shape>(&geometry_);
    const Eigen::Matrix3d r = pose.linear();
    const Eigen::Vector3d centre = pose * centre_;
    const double rounding = rounding_of(pose, centre_);
    const Eigen::Vector3d slack = Eigen::Vector3d::Constant(slack_ + rounding);

    if (requested_ > 0 && !turns_by_quarters(r)) {
        const Eigen::Matrix3f rows = r.cast<float>();
        Eigen::Vector3f lo, hi;
        if (cooked_) {
            for (int axis = 0; axis < 3; ++axis) {
                const Eigen::Vector3f row = rows.row(axis);
                hi[axis] = cooked_->most(row), lo[axis] = -cooked_->most(-row);
            }
        } else if (!support_.empty()) {
            support_.box(rows, lo, hi);
        } else {
            const Eigen::Matrix<float, 3, 3, Eigen::RowMajor> by_rows = rows;
            const auto& [x, y, z] = points_.xyz;
            aabb_kernel().support_box(x.data(), y.data(), z.data(), static_cast<std::uint32_t>(x.size()),
                                      by_rows.data(), lo.data(), hi.data());
        }
        const Eigen::Vector3d low = lo.cast<double>(), high = hi.cast<double>();
        // With |r . p| <= |p|, coordinates, products and sums err by at most 9 * 2^-24 |p|.
        const Eigen::Vector3d float_slack = Eigen::Vector3d::Constant(0x1p-20 * radius_ + rounding);
        return around(centre + 0.5 * (low + high), 0.5 * (high - low) + float_slack);
    }
    if (const auto* cone = shape ? std::get_if<Cone>(shape) : nullptr) {
        const Aabb box = cone_box(*cone, r);
        return around(centre + box.centre(), box.half_extent() + slack);
    }
    if (shape && !points_of(geometry_)) return around(centre, std::visit(RotatedHalf{r}, *shape) + slack);
    return around(centre, r.cwiseAbs() * half_ + slack);
}

Aabb PoseBounds::sphere_box(const Eigen::Isometry3d& pose) const
{
    if (is_half_space()) return half_space_box(pose);
    const double radius = radius_ + slack_ + rounding_of(pose, centre_);
    return around(pose * centre_, Eigen::Vector3d::Constant(radius));
}

} // namespace oncollide
