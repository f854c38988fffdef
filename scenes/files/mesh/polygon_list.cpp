#include <oncollide/scenes/files/mesh/polygon_list.hpp>

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace oncollide {

namespace {

std::uint32_t largest_corner(std::span<const Triangle> triangles)
{
    std::uint32_t largest = 0;
    for (const Triangle& t : triangles) largest = std::max({largest, t[0], t[1], t[2]});
    return largest;
}

} // namespace

void PolygonList::reserve(std::size_t triangles)
{
    reserve_large(triangles_, triangles);
}

void PolygonList::add_polygon(std::span<const std::int64_t> corners, std::size_t line)
{
    note(line);
    polygons_.push_back({triangles_.size(), corners_.size()});
    corners_.insert(corners_.end(), corners.begin(), corners.end());
}

std::size_t PolygonList::line_of(std::size_t polygon) const
{
    const auto after = std::ranges::upper_bound(runs_, polygon, {}, &Run::polygon);
    return after == runs_.begin() ? 0 : after[-1].line + (polygon - after[-1].polygon);
}

void PolygonList::check(const MeshSource& source, std::span<const std::int64_t> corners, std::size_t polygon,
                        std::size_t vertices, std::int64_t first) const
{
    for (const std::int64_t corner : corners)
        if (corner < 0 || corner >= static_cast<std::int64_t>(vertices))
            source.fail(fmt::format("face uses vertex {}, but the file has {} vertices, counted from {}",
                                    corner + first, vertices, first),
                        line_of(polygon));
}

std::vector<Triangle> PolygonList::triangulate(const MeshSource& source, std::span<const Eigen::Vector3d> vertices,
                                               std::int64_t first)
{
    const bool in_range = triangles_.empty() || largest_corner(triangles_) < vertices.size();
    if (polygons_.empty() && in_range) return std::move(triangles_);

    std::vector<Triangle> all;
    all.reserve(triangles_.size() + 2 * polygons_.size());
    std::vector<std::uint32_t> polygon;
    std::size_t t = 0;
    const auto take_triangles = [&](std::size_t end, std::size_t polygons) {
        for (; t < end; ++t) {
            const Triangle& corners = triangles_[t];
            if (!in_range)
                check(source, std::array<std::int64_t, 3>{corners[0], corners[1], corners[2]}, t + polygons,
                      vertices.size(), first);
            all.push_back(corners);
        }
    };
    for (std::size_t p = 0; p < polygons_.size(); ++p) {
        take_triangles(polygons_[p].triangles, p);
        const std::size_t end = p + 1 < polygons_.size() ? polygons_[p + 1].begin : corners_.size();
        const std::span corners = std::span(corners_).subspan(polygons_[p].begin, end - polygons_[p].begin);
        check(source, corners, t + p, vertices.size(), first);
        polygon.assign(corners.begin(), corners.end());
        if (!oncollide::triangulate(vertices, polygon, all))
            source.fail(fmt::format("face has {} corners and is not convex; at most {} corners are allowed then",
                                    polygon.size(), most_concave_corners),
                        line_of(t + p));
    }
    take_triangles(triangles_.size(), polygons_.size());
    return all;
}

} // namespace oncollide
