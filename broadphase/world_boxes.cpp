#include <oncollide/broadphase/world_boxes.hpp>

#include <cmath>

#include <oncollide/base/cpu_features.hpp>
#include <oncollide/base/parallel.hpp>
#include <oncollide/broadphase/box_kernel.hpp>
#include <oncollide/scenes/model/convex_hull.hpp>

namespace oncollide {

const BoxKernel& box_kernel()
{
    static const BoxKernel kernel = ONCOLLIDE_CHOOSE(box_kernel);
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

/// By how much a centre in the world and the frames of other bodies may be off: a rotation and a shift of large numbers
/// may leave a small one, and matrices in double are 2^-52 from rotations.
double rounding_of(const Eigen::Isometry3d& pose, const Eigen::Vector3d& centre)
{
    return 0x1p-49 * (centre.lpNorm<1>() + pose.translation().lpNorm<Eigen::Infinity>());
}

/// Half-extents of the box of a shape whose axis-aligned frame is turned by `r`.
struct TurnedHalf {
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
    Eigen::Vector3d operator()(const ConvexHull&) const { return {}; } // has support points
};

} // namespace

WorldBoxes::WorldBoxes(const Scene& scene)
{
    sources_.resize(scene.geometries.size());
    for (std::size_t g = 0; g < sources_.size(); ++g) {
        const Aabb bounds = bounds_of(scene.geometries[g]);
        sources_[g].centre = bounds.centre(), sources_[g].half = bounds.half_extent();
        sources_[g].radius = bounds.half_extent().norm() * (1 + 1e-15);
        sources_[g].slack = 1e-15 * (sources_[g].radius + sources_[g].centre.norm());
    }
}

void WorldBoxes::prepare(const Scene& scene, GeometryId geometry)
{
    Source& source = sources_[index(geometry)];
    const auto& data = scene.geometries[index(geometry)].data;
    const std::vector<Eigen::Vector3d>* points = nullptr;
    if (const auto* mesh = std::get_if<Mesh>(&data)) points = &mesh->vertices;
    if (const auto* shape = std::get_if<Shape>(&data))
        if (const auto* hull = std::get_if<ConvexHull>(shape)) points = &hull->points;
    if (!points || source.hull_known) return;

    const bool want_hull =
        points->size() >= smallest_mesh_worth_a_hull && source.boxes_asked >= boxes_that_pay_for_a_hull;
    if (!source.x.empty() && !want_hull) return;

    const auto fill = [&](auto&& indices) {
        source.x.clear(), source.y.clear(), source.z.clear();
        const auto put = [&](const Eigen::Vector3d& p) {
            source.x.push_back(static_cast<float>(p.x())), source.y.push_back(static_cast<float>(p.y()));
            source.z.push_back(static_cast<float>(p.z()));
        };
        for (std::uint32_t i : indices) put((*points)[i] - source.centre);
        while (source.x.size() % 8) put((*points)[*std::begin(indices)] - source.centre);
    };
    // Rounding of support_box: with |r . p| <= |p|, coordinates, products and sums err by at most 9 * 2^-24 |p|.
    const double rounding = std::ldexp(source.radius, -20);
    if (want_hull) {
        const Hull hull = convex_hull(*points);
        fill(hull.vertices);
        source.slack = rounding + hull.slack;
        source.hull_known = true;
        return;
    }
    std::vector<std::uint32_t> used;
    if (const auto* mesh = std::get_if<Mesh>(&data)) {
        std::vector<std::uint8_t> seen(points->size());
        for (const Triangle& t : mesh->triangles)
            for (std::uint32_t v : t)
                if (!seen[v]) seen[v] = 1, used.push_back(v);
    } else {
        for (std::uint32_t v = 0; v < points->size(); ++v) used.push_back(v);
    }
    fill(used);
    source.slack = rounding;
    source.hull_known = points->size() < smallest_mesh_worth_a_hull;
}

Aabb WorldBoxes::box_of(const Scene& scene, std::uint32_t body) const
{
    const std::uint32_t geometry = index(scene.geometry[body]);
    const Source& source = sources_[geometry];
    const Eigen::Isometry3d& pose = scene.poses[body];
    const Eigen::Matrix3d r = pose.linear();
    const Eigen::Vector3d centre = pose * source.centre;
    const Eigen::Vector3d slack = Eigen::Vector3d::Constant(source.slack + rounding_of(pose, source.centre));

    if (!source.x.empty()) {
        float rows[9], lo[3], hi[3];
        for (int i = 0; i < 9; ++i) rows[i] = static_cast<float>(r(i / 3, i % 3));
        box_kernel().support_box(source.x.data(), source.y.data(), source.z.data(),
                                 static_cast<std::uint32_t>(source.x.size()), rows, lo, hi);
        const Eigen::Vector3d low(lo[0], lo[1], lo[2]), high(hi[0], hi[1], hi[2]);
        return around(centre + 0.5 * (low + high), 0.5 * (high - low) + slack);
    }
    if (const auto* shape = std::get_if<Shape>(&scene.geometries[geometry].data))
        return around(centre, std::visit(TurnedHalf{r}, *shape) + slack);
    return around(centre, r.cwiseAbs() * source.half + slack);
}

Aabb WorldBoxes::sphere_box(const Scene& scene, std::uint32_t body) const
{
    const Source& source = sources_[index(scene.geometry[body])];
    const Eigen::Isometry3d& pose = scene.poses[body];
    const double reach = source.radius + source.slack + rounding_of(pose, source.centre);
    return around(pose * source.centre, Eigen::Vector3d::Constant(reach));
}

void WorldBoxes::update(const Scene& scene, std::span<const std::uint32_t> bodies, int threads, std::span<Aabb> boxes)
{
    for (std::uint32_t body : bodies) ++sources_[index(scene.geometry[body])].boxes_asked;
    for (std::uint32_t body : bodies) prepare(scene, scene.geometry[body]);
    parallel_chunks(bodies.size(), 2048, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) boxes[bodies[i]] = box_of(scene, bodies[i]);
    });
}

} // namespace oncollide
