#include <oncollide/broadphase/pose_bounds.hpp>

#include <cmath>

#include <oncollide/base/cpu_features.hpp>
#include <oncollide/broadphase/box_kernel.hpp>
#include <oncollide/scenes/model/convex_hull.hpp>

namespace oncollide {

const BoxKernel& box_kernel()
{
    static const BoxKernel kernel = choose(baseline::box_kernel(), avx2::box_kernel(), avx512::box_kernel());
    return kernel;
}

namespace {

// Finding a hull costs about as much as boxing this many times the mesh's vertices once each.
constexpr std::uint64_t boxes_that_pay_for_a_hull = 1500;
constexpr std::size_t smallest_mesh_worth_a_hull = 64;

Aabb around(const Eigen::Vector3d& centre, const Eigen::Vector3d& half)
{
    // Doubles far from the origin: the sums below round by at most this much.
    const Eigen::Vector3d h = half + Eigen::Vector3d::Constant(1e-15 * (centre.lpNorm<Eigen::Infinity>() + half.sum()));
    Aabb box;
    box.min = centre - h, box.max = centre + h;
    return box;
}

/// By how much a centre in the world and the frames of other bodies may be off: a rotation and a translation of large
/// numbers may leave a small one, and matrices in double are 2^-52 from rotations.
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
        const Eigen::Vector3d across = (1.0 - r.col(2).array().square()).max(0.0).sqrt();
        return r.col(2).cwiseAbs() * (0.5 * c.length) + across * c.radius;
    }
    Eigen::Vector3d operator()(const ConvexHull&) const { return {}; } // not called: has points
    Eigen::Vector3d operator()(const Ellipsoid& e) const
    {
        return (r.array().square().matrix() * e.semi_axes.array().square().matrix()).cwiseSqrt() * (1 + 1e-15);
    }
    Eigen::Vector3d operator()(const Cone&) const { return {}; }      // not called: its box is not about its centre
    Eigen::Vector3d operator()(const HalfSpace&) const { return {}; } // not called: has no end
};

/// About a cone's centre: of its apex and its base.
Aabb cone_box(const Cone& cone, const Eigen::Matrix3d& r)
{
    const Eigen::Vector3d apex = 0.5 * cone.length * r.col(2), disc = RotatedHalf{r}(Cylinder{cone.radius, 0});
    return {apex.cwiseMin(-apex - disc), apex.cwiseMax(-apex + disc)};
}

/// Of a half-space: all space, but for what is certainly outside of one that a quarter turn moved.
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

/// The vertices that support a geometry's box, if it has any; null: it has a closed form.
const std::vector<Eigen::Vector3d>* points_of(const GeometryData& geometry)
{
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) return &mesh->vertices;
    if (const auto* shape = std::get_if<Shape>(&geometry))
        if (const auto* hull = std::get_if<ConvexHull>(shape)) return &hull->points;
    return nullptr;
}

std::vector<std::uint32_t> used_points(const GeometryData& geometry, std::size_t count)
{
    std::vector<std::uint32_t> used;
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) {
        std::vector<std::uint8_t> seen(count);
        for (const Triangle& t : mesh->triangles)
            for (std::uint32_t v : t)
                if (!seen[v]) seen[v] = 1, used.push_back(v);
    } else {
        for (std::uint32_t v = 0; v < count; ++v) used.push_back(v);
    }
    return used;
}

} // namespace

PoseBounds::PoseBounds(const GeometryData& geometry) : geometry_(geometry)
{
    const Aabb bounds = bounds_of(geometry);
    centre_ = bounds.centre(), half_ = bounds.half_extent();
    radius_ = bounds.half_extent().norm() * (1 + 1e-15);
    slack_ = 1e-15 * (radius_ + centre_.norm());
}

void PoseBounds::set_support(const std::vector<Eigen::Vector3d>& points, const std::vector<std::uint32_t>& used)
{
    x_.clear(), y_.clear(), z_.clear();
    const auto put = [&](const Eigen::Vector3d& p) {
        x_.push_back(static_cast<float>(p.x())), y_.push_back(static_cast<float>(p.y()));
        z_.push_back(static_cast<float>(p.z()));
    };
    for (std::uint32_t i : used) put(points[i] - centre_);
    while (x_.size() % 8) put(points[used.front()] - centre_);
}

void PoseBounds::expect(std::uint64_t boxes)
{
    requested_ += boxes;
    const std::vector<Eigen::Vector3d>* points = points_of(geometry_);
    if (!points || final_ || boxes == 0) return;
    const bool large = points->size() >= smallest_mesh_worth_a_hull;
    const bool want_hull = large && requested_ >= boxes_that_pay_for_a_hull;
    if (!x_.empty() && !want_hull) return;

    // Rounding of support_box: with |r . p| <= |p|, coordinates, products and sums err by at most 9 * 2^-24 |p|.
    const double rounding = std::ldexp(radius_, -20);
    if (want_hull) {
        const Hull hull = convex_hull(*points);
        set_support(*points, hull.vertices);
        slack_ = rounding + hull.slack;
    } else {
        set_support(*points, used_points(geometry_, points->size()));
        slack_ = rounding;
    }
    final_ = want_hull || !large;
}

Aabb PoseBounds::box(const Eigen::Isometry3d& pose) const
{
    const auto* shape = std::get_if<Shape>(&geometry_);
    if (shape && std::holds_alternative<HalfSpace>(*shape)) return half_space_box(pose);
    const Eigen::Matrix3d r = pose.linear();
    const Eigen::Vector3d centre = pose * centre_;
    const Eigen::Vector3d slack = Eigen::Vector3d::Constant(slack_ + rounding_of(pose, centre_));

    if (!x_.empty()) {
        float rows[9], lo[3], hi[3];
        for (int i = 0; i < 9; ++i) rows[i] = static_cast<float>(r(i / 3, i % 3));
        box_kernel().support_box(x_.data(), y_.data(), z_.data(), static_cast<std::uint32_t>(x_.size()), rows, lo, hi);
        const Eigen::Vector3d low(lo[0], lo[1], lo[2]), high(hi[0], hi[1], hi[2]);
        return around(centre + 0.5 * (low + high), 0.5 * (high - low) + slack);
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
    if (const auto* shape = std::get_if<Shape>(&geometry_); shape && std::holds_alternative<HalfSpace>(*shape))
        return half_space_box(pose);
    const double radius = radius_ + slack_ + rounding_of(pose, centre_);
    return around(pose * centre_, Eigen::Vector3d::Constant(radius));
}

} // namespace oncollide
