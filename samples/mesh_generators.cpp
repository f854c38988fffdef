#include <oncollide/samples/generators.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <oncollide/base/error.hpp>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/noise.hpp>
#include <oncollide/scenes/model/surface_grid.hpp>

namespace oncollide {

namespace {

constexpr int most_per_mesh = 100'000'000;

void check_size(const char* mesh, const char* what, double value)
{
    if (!(value > 0 && value <= 1e15))
        throw Error(ErrorKind::usage,
                    fmt::format("{}: {} is {}; it must be above 0 and at most 1e15", mesh, what, value));
}

void check_order(const char* mesh, const char* small, double low, const char* large, double high)
{
    if (!(low < high))
        throw Error(ErrorKind::usage, fmt::format("{}: {} ({}) must be below {} ({})", mesh, small, low, large, high));
}

void check_count(const char* mesh, const char* what, long long value, int least, int most)
{
    if (value < least || value > most)
        throw Error(ErrorKind::usage,
                    fmt::format("{}: {} is {}; it must be from {} to {}", mesh, what, value, least, most));
}

/// The octahedron's faces cut `levels` times into four, every vertex on the sphere.
Mesh subdivided_octahedron(double radius, int levels)
{
    const int n = 1 << levels;
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    octasphere(n, points, triangles);
    for (Eigen::Vector3d& p : points) p *= radius;
    return make_mesh("sphere", std::move(points), std::move(triangles));
}

/// Bands of quads between two poles. The number of bands makes quads at the equator nearly square.
Mesh lat_long_sphere(double radius, int triangles)
{
    const int half = triangles / 2; // segments * (bands - 1), before the extra triangles
    int bands = 3;
    const auto badness = [&](int b) { return std::abs(std::log(half / (b - 1) / (2.0 * b))); };
    for (int b = 3; half / (b - 1) >= 3 && b - 1 <= half / 3; ++b)
        if (badness(b) < badness(bands)) bands = b;
    const int segments = half / (bands - 1), extra = half - segments * (bands - 1);

    const auto point = [&](double u, double v) -> Eigen::Vector3d {
        const Circle around = circle(u / segments), up = circle(0.5 * (v + 1) / bands); // from the south pole
        return radius * Eigen::Vector3d(up.sine * around.cosine, up.sine * around.sine, -up.cosine);
    };
    GridBuilder grid(segments, bands - 2, false);
    grid.build(extra, point);
    const auto north = static_cast<std::uint32_t>(grid.points.size()), south = north + 1;
    grid.points.push_back({0, 0, radius}), grid.points.push_back({0, 0, -radius});
    for (int i = 0; i < segments; ++i) {
        grid.triangles.push_back({south, grid.at(i + 1, 0), grid.at(i, 0)});
        grid.triangles.push_back({north, grid.at(i, bands - 2), grid.at(i + 1, bands - 2)});
    }
    return make_mesh("sphere", std::move(grid.points), std::move(grid.triangles));
}

/// A closed tube of `around` by `along` quads, as square as the lengths allow, with exactly half * 2 triangles.
template <class Point>
Mesh closed_tube(const char* name, int triangles, double length, double girth, Point point)
{
    const int half = triangles / 2;
    const int around = std::clamp(static_cast<int>(std::lround(std::sqrt(half * girth / length))), 3, half / 3);
    const int along = half / around, extra = half - around * along;
    GridBuilder grid(along, around, true);
    grid.build(extra, [&](double u, double v) { return point(u / along, v / around); });
    return make_mesh(name, std::move(grid.points), std::move(grid.triangles));
}

Eigen::Vector3d random_direction(std::uint64_t seed, std::uint64_t index, std::uint64_t k)
{
    const double z = 2 * u01(seed, index, k) - 1, ring = std::sqrt(std::max(0.0, 1 - z * z));
    const Circle turn = circle(u01(seed, index, k + 1));
    return {ring * turn.cosine, ring * turn.sine, z};
}

/// A random unit vector and a unit vector perpendicular to it.
struct Directions {
    Eigen::Vector3d along, across;
    Directions(std::uint64_t seed, std::uint64_t index) : along(random_direction(seed, index, 10))
    {
        int thin = 0;
        along.cwiseAbs().minCoeff(&thin);
        const Eigen::Vector3d side = along.cross(Eigen::Vector3d::Unit(thin)).normalized();
        const Circle turn = circle(u01(seed, index, 12));
        across = turn.cosine * side + turn.sine * along.cross(side);
    }
};

Eigen::Vector3d random_point(double size, std::uint64_t seed, std::uint64_t index)
{
    return size * Eigen::Vector3d(u01(seed, index, 0) - 0.5, u01(seed, index, 1) - 0.5, u01(seed, index, 2) - 0.5);
}

template <class Corners>
Mesh separate_triangles(const char* name, int count, Corners corners)
{
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    points.reserve(3 * static_cast<std::size_t>(count)), triangles.reserve(static_cast<std::size_t>(count));
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(count); ++i) {
        for (const Eigen::Vector3d& corner : corners(i)) points.push_back(corner);
        triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return make_mesh(name, std::move(points), std::move(triangles));
}

} // namespace

Mesh make_box_mesh(const Eigen::Vector3d& half)
{
    for (int axis = 0; axis < 3; ++axis) check_size("box", "a half-extent", half[axis]);
    return box_mesh(half);
}

Mesh make_box_mesh(const Eigen::Vector3d& half, int cells)
{
    for (int axis = 0; axis < 3; ++axis) check_size("box", "a half-extent", half[axis]);
    check_count("box", "the number of cells along an edge", cells, 1, 1000);
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            const auto first = static_cast<std::uint32_t>(vertices.size()), row = static_cast<std::uint32_t>(cells) + 1;
            for (int y = 0; y <= cells; ++y)
                for (int x = 0; x <= cells; ++x) {
                    Eigen::Vector3d p;
                    p[axis] = side, p[(axis + 1) % 3] = 2.0 * x / cells - 1, p[(axis + 2) % 3] = 2.0 * y / cells - 1;
                    vertices.push_back(p.cwiseProduct(half));
                }
            for (int y = 0; y < cells; ++y)
                for (int x = 0; x < cells; ++x) {
                    const std::uint32_t v = first + static_cast<std::uint32_t>(y) * row + static_cast<std::uint32_t>(x);
                    Triangle one{v, v + 1, v + row}, two{v + 1, v + row + 1, v + row};
                    if (side < 0) std::swap(one[0], one[1]), std::swap(two[0], two[1]);
                    triangles.push_back(one), triangles.push_back(two);
                }
        }
    return make_mesh("box", std::move(vertices), std::move(triangles));
}

Mesh make_sphere_mesh(double radius, int triangles)
{
    check_size("sphere", "the radius", radius);
    check_count("sphere", "the number of triangles", triangles, 8, most_per_mesh);
    int levels = 0;
    while ((8LL << (2 * levels)) < triangles) ++levels;
    if ((8LL << (2 * levels)) == triangles) return subdivided_octahedron(radius, levels);
    if (triangles < 12) return subdivided_octahedron(radius, 0);
    return lat_long_sphere(radius, triangles);
}

Mesh make_torus_mesh(double major, double minor, int triangles)
{
    check_size("torus", "the tube radius", minor);
    check_size("torus", "the ring radius", major);
    check_order("torus", "the tube radius", minor, "the ring radius", major);
    check_count("torus", "the number of triangles", triangles, 18, most_per_mesh);
    return closed_tube("torus", triangles, major, minor, [&](double u, double v) -> Eigen::Vector3d {
        const Circle ring = circle(u), tube = circle(v);
        const double radius = major + minor * tube.cosine;
        return {radius * ring.cosine, radius * ring.sine, minor * tube.sine};
    });
}

Mesh make_torus_knot_mesh(int p, int q, double major, double minor, double tube, int triangles)
{
    check_count("torus knot", "p", p, 1, 1000);
    check_count("torus knot", "q", q, 1, 1000);
    if (std::gcd(p, q) != 1)
        throw Error(ErrorKind::usage,
                    fmt::format("torus knot: p and q must have no common divisor, not {} and {}", p, q));
    check_size("torus knot", "the tube radius", tube);
    check_size("torus knot", "the minor radius", minor);
    check_size("torus knot", "the major radius", major);
    check_order("torus knot", "the minor radius", minor, "the major radius", major);
    check_count("torus knot", "the number of triangles", triangles, 18, most_per_mesh);

    // The centre line winds p times around z on a torus, q times around its tube. The torus' normal is perpendicular to
    // the line everywhere and closes with it, so it serves as the tube's frame.
    const auto point = [&](double u, double v) -> Eigen::Vector3d {
        const Circle ring = circle(p * u), wind = circle(q * u), around = circle(v);
        const double reach = major + minor * wind.cosine;
        const Eigen::Vector3d outward(ring.cosine, ring.sine, 0), sideways(-ring.sine, ring.cosine, 0);
        const Eigen::Vector3d normal = wind.cosine * outward + wind.sine * Eigen::Vector3d::UnitZ();
        const Eigen::Vector3d climb = -wind.sine * outward + wind.cosine * Eigen::Vector3d::UnitZ();
        const Eigen::Vector3d tangent = (p * reach * sideways + q * minor * climb).normalized();
        return reach * outward + minor * wind.sine * Eigen::Vector3d::UnitZ() +
               tube * (around.cosine * normal + around.sine * normal.cross(tangent));
    };
    const double length = std::hypot(p * major, q * minor);
    return closed_tube("torus knot", triangles, length, tube, point);
}

Mesh make_gear_mesh(int teeth, double root_radius, double tip_radius, double thickness, double bore_radius)
{
    check_count("gear", "the number of teeth", teeth, 3, most_per_mesh / 32);
    check_size("gear", "the bore radius", bore_radius);
    check_size("gear", "the root radius", root_radius);
    check_size("gear", "the tip radius", tip_radius);
    check_size("gear", "the thickness", thickness);
    check_order("gear", "the bore radius", bore_radius, "the root radius", root_radius);
    check_order("gear", "the root radius", root_radius, "the tip radius", tip_radius);

    // A tooth has four points of the rim; the bore has a point below each. The ring's section has four walls.
    const int rim = 4 * teeth;
    constexpr double share[4] = {0.0, 0.30, 0.42, 0.88}; // of a tooth's angle: root, root, tip, tip
    GridBuilder grid(rim, 4, true);
    grid.build(0, [&](double u, double v) -> Eigen::Vector3d {
        const int i = static_cast<int>(u) % rim, side = static_cast<int>(v) % 4;
        const Circle turn = circle((i / 4 + share[i % 4]) / teeth);
        const bool outside = side == 0 || side == 1, top = side == 1 || side == 2;
        const double reach = !outside ? bore_radius : i % 4 < 2 ? root_radius : tip_radius;
        return {reach * turn.cosine, reach * turn.sine, top ? 0.5 * thickness : -0.5 * thickness};
    });
    return make_mesh("gear", std::move(grid.points), std::move(grid.triangles));
}

Mesh make_sheet_mesh(double size, int cells)
{
    return make_sheet_mesh(Eigen::Vector2d(size, size), {cells, cells});
}

Mesh make_sheet_mesh(const Eigen::Vector2d& size, const std::array<int, 2>& cells)
{
    for (const double side : size) check_size("sheet", "the size", side);
    for (const int count : cells) check_count("sheet", "the number of cells", count, 1, 5000);
    GridBuilder grid(cells[0], cells[1], false, false);
    grid.build(0, [&](double u, double v) -> Eigen::Vector3d {
        return {size.x() * (u / cells[0] - 0.5), size.y() * (v / cells[1] - 0.5), 0};
    });
    return make_mesh("sheet", std::move(grid.points), std::move(grid.triangles));
}

Mesh make_terrain_mesh(double size, double height, int cells, std::uint64_t seed)
{
    check_size("terrain", "the size", size);
    check_size("terrain", "the height", height);
    check_count("terrain", "the number of cells", cells, 1, 5000);
    GridBuilder grid(cells, cells, false, false);
    grid.build(0, [&](double u, double v) -> Eigen::Vector3d {
        const double x = u / cells, y = v / cells;
        return {size * (x - 0.5), size * (y - 0.5), height * fractal_noise(x, y, seed)};
    });
    return make_mesh("terrain", std::move(grid.points), std::move(grid.triangles));
}

Mesh make_needles_mesh(int count, double length, double aspect, double size, std::uint64_t seed)
{
    check_count("needles", "the count", count, 1, most_per_mesh);
    check_size("needles", "the length", length);
    check_size("needles", "the aspect", aspect);
    check_size("needles", "the size", size);
    return separate_triangles("needles", count, [&](std::uint64_t i) -> std::array<Eigen::Vector3d, 3> {
        const Directions d(seed, i);
        const Eigen::Vector3d centre = random_point(size, seed, i), side = 0.5 * length / aspect * d.across;
        const Eigen::Vector3d foot = centre - 0.5 * length * d.along;
        return {foot - side, foot + side, centre + 0.5 * length * d.along};
    });
}

Mesh make_soup_mesh(int count, double edge, double size, std::uint64_t seed)
{
    check_count("soup", "the count", count, 1, most_per_mesh);
    check_size("soup", "the edge", edge);
    check_size("soup", "the size", size);
    return separate_triangles("soup", count, [&](std::uint64_t i) -> std::array<Eigen::Vector3d, 3> {
        // An equilateral triangle, its edges stretched by 0.75 to 1.25, around the centre.
        const Directions d(seed, i);
        const auto stretch = [&](std::uint64_t k) { return edge * (0.75 + 0.5 * u01(seed, i, k)); };
        const Eigen::Vector3d a = stretch(20) * d.along;
        const Eigen::Vector3d b = stretch(21) * (0.5 * d.along + std::sqrt(0.75) * d.across);
        const Eigen::Vector3d corner = random_point(size, seed, i) - (a + b) / 3;
        return {corner, corner + a, corner + b};
    });
}

} // namespace oncollide
