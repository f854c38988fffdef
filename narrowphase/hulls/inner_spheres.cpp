#include <oncollide/narrowphase/hulls/inner_spheres.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/feature_distance.hpp>
#include <oncollide/scenes/model/mesh_topology.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr std::size_t most_enclosed = 32;

/// Lower bound of the distance of a point from the nearest triangle.
double distance_to(const Mesh& mesh, const Vector3d& point)
{
    const double rounding = 0x1p-40 * ((mesh.bounds.centre() - point).norm() + mesh.bounds.diagonal());
    double nearest = std::numeric_limits<double>::infinity();
    for (const Triangle& t : mesh.triangles) {
        const Vector3d p = mesh.vertices[t[0]] - point, q = mesh.vertices[t[1]] - point,
                       r = mesh.vertices[t[2]] - point;
        const Vector3d lo = p.cwiseMin(q).cwiseMin(r), hi = p.cwiseMax(q).cwiseMax(r);
        if (lo.cwiseMax(-hi).cwiseMax(0).squaredNorm() >= nearest * nearest) continue;
        nearest = std::min(nearest, nearest_on({p, q, r}, Vector3d::Zero(), rounding, nearest).at.norm());
    }
    return std::max(nearest - 2 * rounding, 0.0) * (1 - 0x1p-20);
}

/// True if a ray from the point crosses the surface an odd number of times. As every edge belongs to an even number of
/// triangles, no path then leads from the point to the outside.
bool encloses(const Mesh& mesh, const Vector3d& point)
{
    constexpr std::uint64_t most_rays = 8; // rays very rarely touch an edge or a corner
    for (std::uint64_t ray = 0; ray < most_rays; ++ray) {
        Vector3d way(u01(3, ray, 0) - 0.5, u01(3, ray, 1) - 0.5, u01(3, ray, 2) - 0.5);
        const Vector3d tip = point + 2 * mesh.bounds.diagonal() * way.normalized();
        bool odd = false, certain = true;
        for (const Triangle& t : mesh.triangles) {
            const Vector3d &p = mesh.vertices[t[0]], &q = mesh.vertices[t[1]], &r = mesh.vertices[t[2]];
            const int sides[3] = {orient3d(point, tip, p, q), orient3d(point, tip, q, r), orient3d(point, tip, r, p)};
            const auto [least, most] = std::minmax({sides[0], sides[1], sides[2]});
            if (least * most < 0) continue;
            const int from = orient3d(p, q, r, point), to = orient3d(p, q, r, tip);
            if (from * to > 0) continue;
            if (least * most == 0 || from * to == 0) certain = false;
            odd = !odd;
        }
        if (certain) return odd;
    }
    return false;
}

/// Cells of a grid around a mesh, with their distance in layers from the surface, and the cells outside.
class SampleGrid {
public:
    explicit SampleGrid(const Mesh& mesh)
    {
        // Cells along the longest side: few for a mesh with few vertices, for which a fine grid would take most of the
        // time.
        const double cells = std::clamp(0.8 * std::sqrt(double(mesh.vertices.size())), 16.0, 40.0);
        const Vector3d size = mesh.bounds.max - mesh.bounds.min;
        side_ = size.maxCoeff() / cells;
        origin_ = mesh.bounds.min - Vector3d::Constant(1.5 * side_);
        for (int i = 0; i < 3; ++i) cells_[i] = static_cast<int>(size[i] / side_) + 4;
        depth_.assign(static_cast<std::size_t>(cells_.prod()), unknown);
        for (const Triangle& t : mesh.triangles) mark(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
        flood();
        measure();
    }
    double side() const { return side_; }
    /// Calls visit(centre, layers from the surface) for the cells that the surface separates from the outside.
    void each_enclosed(auto visit) const
    {
        each({0, 0, 0}, cells_ - Vector3i::Ones(), [&](const Vector3i& cell) {
            if (const int depth = depth_[number(cell)]; depth > 0) visit(centre(cell), depth);
        });
    }

private:
    static constexpr std::int16_t unknown = std::numeric_limits<std::int16_t>::max(), surface = 0, outside = -1;

    Vector3d centre(const Vector3i& cell) const
    {
        return origin_ + side_ * (cell.cast<double>() + Vector3d::Constant(0.5));
    }
    std::size_t number(const Vector3i& c) const
    {
        return static_cast<std::size_t>((c[2] * cells_[1] + c[1]) * cells_[0] + c[0]);
    }
    static void each(const Vector3i& from, const Vector3i& to, auto visit)
    {
        for (int z = from[2]; z <= to[2]; ++z)
            for (int y = from[1]; y <= to[1]; ++y)
                for (int x = from[0]; x <= to[0]; ++x) visit(Vector3i(x, y, z));
    }
    /// Calls visit(neighbour) for the neighbours in the grid.
    void each_neighbour(const Vector3i& cell, auto visit) const
    {
        each((cell.array() - 1).cwiseMax(0), (cell.array() + 1).cwiseMin(cells_.array() - 1), visit);
    }
    void mark(const Vector3d& p, const Vector3d& q, const Vector3d& r)
    {
        const Vector3d normal = (q - p).cross(r - p);
        const double reach = 0.5001 * side_ * normal.lpNorm<1>();
        const auto cell_of = [&](const Vector3d& at) { return Vector3i(((at - origin_) / side_).cast<int>()); };
        each(cell_of(p.cwiseMin(q).cwiseMin(r)), cell_of(p.cwiseMax(q).cwiseMax(r)), [&](const Vector3i& cell) {
            if (std::abs(normal.dot(centre(cell) - p)) <= reach) depth_[number(cell)] = surface;
        });
    }
    void flood()
    {
        std::vector<Vector3i> waiting{{0, 0, 0}};
        depth_[0] = outside;
        while (!waiting.empty()) {
            const Vector3i cell = waiting.back();
            waiting.pop_back();
            for (int i = 0; i < 6; ++i) {
                Vector3i next = cell;
                next[i / 2] += i % 2 ? 1 : -1;
                if (next[i / 2] < 0 || next[i / 2] >= cells_[i / 2] || depth_[number(next)] != unknown) continue;
                depth_[number(next)] = outside;
                waiting.push_back(next);
            }
        }
    }
    /// Numbers the layers from the surface inward.
    void measure()
    {
        std::vector<Vector3i> layer, next;
        each({0, 0, 0}, cells_ - Vector3i::Ones(), [&](const Vector3i& cell) {
            if (depth_[number(cell)] == surface) layer.push_back(cell);
        });
        for (std::int16_t depth = 1; !layer.empty(); ++depth, layer.swap(next)) {
            next.clear();
            for (const Vector3i& cell : layer)
                each_neighbour(cell, [&](const Vector3i& near) {
                    if (std::int16_t& of = depth_[number(near)]; of == unknown) of = depth, next.push_back(near);
                });
        }
    }

    double side_;
    Vector3d origin_;
    Vector3i cells_;
    std::vector<std::int16_t> depth_;
};

bool one_piece(const Mesh& mesh)
{
    return std::ranges::all_of(parts_of(mesh), [](std::uint32_t part) { return part == 0; });
}

} // namespace

InnerSpheres::InnerSpheres(const Mesh& mesh)
    : centre_(mesh.bounds.centre()), radius_(0.5 * mesh.bounds.diagonal() * (1 + 0x1p-20))
{
    // Squares of floats must not underflow or overflow.
    if (!(radius_ > 1e-12 && radius_ < 1e12) || !one_piece(mesh)) return;
    if (edges_are_even(mesh)) add_enclosed(mesh);
    add_points(mesh);
    for (int axis = 0; axis < 4; ++axis) column_[axis].resize((count_ + 7) / 8 * 8, axis < 3 ? 0 : -1e30f);
}

void InnerSpheres::add(const Vector3d& at, double radius)
{
    for (int axis = 0; axis < 3; ++axis) column_[axis].push_back(static_cast<float>(at[axis] - centre_[axis]));
    column_[3].push_back(static_cast<float>(radius * (1 - 0x1p-20)));
    ++count_;
}

/// Adds the deepest spheres first, each around the centre of a cell that no sphere so far contains.
void InnerSpheres::add_enclosed(const Mesh& mesh)
{
    struct Cell {
        Vector3d centre;
        int depth;
    };
    const SampleGrid grid(mesh);
    std::vector<Cell> cells;
    grid.each_enclosed([&](const Vector3d& centre, int depth) { cells.push_back({centre, depth}); });
    std::ranges::stable_sort(cells, [](const Cell& a, const Cell& b) { return a.depth > b.depth; });
    std::vector<std::pair<Vector3d, double>> found;
    while (!cells.empty() && enclosed_ < most_enclosed) {
        const Vector3d centre = cells.front().centre;
        const double radius = distance_to(mesh, centre);
        // A sphere that overlaps an enclosed sphere is enclosed, too.
        const bool joined = std::ranges::any_of(
            found, [&](const auto& other) { return (other.first - centre).norm() < other.second + radius; });
        if (radius > 0 && (joined || encloses(mesh, centre))) {
            found.emplace_back(centre, radius);
            add(centre, radius);
            ++enclosed_;
        }
        const double covered = std::max(radius, 0.5 * grid.side());
        std::erase_if(cells, [&](const Cell& cell) { return (cell.centre - centre).norm() <= covered; });
    }
}

/// Adds points that are far from each other.
void InnerSpheres::add_points(const Mesh& mesh)
{
    std::vector<Vector3d> points;
    std::vector<bool> seen(mesh.vertices.size());
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t)
            if (!seen[v]) seen[v] = true, points.push_back(mesh.vertices[v]);
    std::vector<double> apart2(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) apart2[i] = (points[i] - centre_).squaredNorm();
    while (count_ < most_spheres) {
        const auto farthest = std::ranges::max_element(apart2) - apart2.begin();
        const Vector3d point = points[static_cast<std::size_t>(farthest)];
        if (!(apart2[static_cast<std::size_t>(farthest)] > 0) && count_ > enclosed_) return;
        add(point, 0);
        for (std::size_t i = 0; i < points.size(); ++i)
            apart2[i] = std::min(apart2[i], (points[i] - point).squaredNorm());
    }
}

double meeting_depth(const InnerSpheres& a, const InnerSpheres& b, const RelativePose& b_to_a)
{
    if (a.empty() || b.empty()) return 0;
    static OverlapSpheres* const overlap = ONCOLLIDE_CHOOSE_TO_AVX2(overlap_spheres);
    const Vector3d between = b_to_a(b.centre()) - a.centre();
    float rotation[9], translation[3];
    for (int i = 0; i < 9; ++i) rotation[i] = static_cast<float>(b_to_a.rotation(i / 3, i % 3));
    for (int i = 0; i < 3; ++i) translation[i] = static_cast<float>(between[i]);
    const SphereOverlap found = overlap(a.columns(), b.columns(), rotation, translation);
    // Poses may be 2^-20 from rigid.
    const double rounding = 0x1p-17 * (a.radius() + b.radius()) + 0x1p-46 * b_to_a.translation.norm();
    const double depth =
        std::min({double(found.depth), found.beyond_a - a.radius(), found.beyond_b - b.radius()}) - rounding;
    return std::max(depth, 0.0);
}

} // namespace oncollide
