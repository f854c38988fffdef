#include <oncollide/samples/bodies_above.hpp>

#include <cmath>
#include <limits>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/sample_geometry.hpp>

namespace oncollide {

using Eigen::Vector3d;

std::vector<Vector3d> surface_points(const GeometryData& geometry)
{
    constexpr std::size_t enough = 20'000;
    std::vector<Vector3d> points;
    if (const auto* map = std::get_if<OccupancyMap>(&geometry)) {
        map->each_box([&](const Aabb& box) { points.push_back({box.centre().x(), box.centre().y(), box.max.z()}); });
    } else if (const auto* terrain = std::get_if<Terrain>(&geometry)) {
        const std::uint32_t step = 1 + std::uint32_t(std::sqrt(double(terrain->cells()) / double(enough)));
        for (std::uint32_t row = 0; row < terrain->rows(); row += step)
            for (std::uint32_t column = 0; column < terrain->columns(); column += step)
                if (const Vector3d p = terrain->point(column, row); p.allFinite()) points.push_back(p);
    } else if (const auto* mesh = std::get_if<Mesh>(&geometry)) {
        points = mesh->vertices;
    } else {
        points = {bounds_of(geometry).min, bounds_of(geometry).max};
    }
    const std::size_t step = 1 + points.size() / enough;
    std::vector<Vector3d> some;
    for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
    return some;
}

double height_at(const Terrain& terrain, double x, double y)
{
    const double c = (x - terrain.x(0)) / terrain.spacing().x(), r = (y - terrain.y(0)) / terrain.spacing().y();
    if (!(c >= 0 && r >= 0 && c < terrain.cells_x() && r < terrain.cells_y()))
        return std::numeric_limits<double>::infinity();
    const auto column = std::uint32_t(c), row = std::uint32_t(r);
    const double u = c - column, v = r - row;
    const auto z = [&](std::uint32_t dc, std::uint32_t dr) { return terrain.point(column + dc, row + dr).z(); };
    // The lower triangle's corners, or the upper one's, of a rising diagonal.
    return u >= v ? z(0, 0) + u * (z(1, 0) - z(0, 0)) + v * (z(1, 1) - z(1, 0))
                  : z(0, 0) + v * (z(0, 1) - z(0, 0)) + u * (z(1, 1) - z(0, 1));
}

std::vector<GeometryId> add_meshes_of_a_metre(SceneInfo& scene)
{
    const auto mesh = [&](const char* name, Json generator) {
        return add_geometry(scene, name, {{"mesh", {{"generate", std::move(generator)}}}});
    };
    return {mesh("knot", {{"kind", "torus_knot"},
                          {"p", 2},
                          {"q", 3},
                          {"major", 0.5},
                          {"minor", 0.2},
                          {"tube", 0.1},
                          {"triangles", 6000}}),
            mesh("ring", {{"kind", "torus"}, {"major", 0.6}, {"minor", 0.2}, {"triangles", 9000}}),
            mesh("ball", {{"kind", "sphere"}, {"radius", 0.6}, {"triangles", 13'000}})};
}

void add_bodies_above(SceneBuilder scene, const std::vector<Vector3d>& points, const Aabb& bounds,
                      const std::vector<GeometryId>& of, int count, std::uint64_t seed)
{
    for (int i = 0; i < count; ++i) {
        if (scene.skip_body()) continue;
        const auto random = [&](std::uint64_t k) { return u01(seed, std::uint64_t(i), k); };
        const Vector3d at = points[std::size_t(random(0) * double(points.size()))];
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() = at + Vector3d(random(1) - 0.5, random(2) - 0.5, 1.2 * random(3));
        const Vector3d axis = Vector3d(random(4) - 0.5, random(5) - 0.5, random(6) - 0.4999).normalized();
        pose.linear() = Eigen::AngleAxisd(2 * M_PI * random(7), axis).toRotationMatrix();
        const Aabb walls{bounds.min.array() - 2, bounds.max.array() + 2};
        pose.translation() = pose.translation().cwiseMax(walls.min).cwiseMin(walls.max);
        const Vector3d velocity = 0.1 * Vector3d(random(8) - 0.5, random(9) - 0.5, random(10) - 0.5);
        scene.add_body({.geometry = of[std::size_t(i) % of.size()],
                        .pose = pose,
                        .motion = Drift{velocity, {0.02, 0, 0.05}, walls}});
    }
}

} // namespace oncollide
