#include "verify/cases/terrain_shape.hpp"

#include <algorithm>

namespace oncollide::tools {

Place TerrainDraw::away(std::int64_t& length)
{
    static constexpr std::int64_t vectors[][4] = {{1, 0, 0, 1}, {3, 4, 0, 5}, {8, 15, 0, 17}, {1, 2, 2, 3},
                                                  {2, 3, 6, 7}, {1, 4, 8, 9}, {4, 7, 4, 9},   {8, 9, 12, 17}};
    const auto& v = vectors[number(0, 7)];
    const std::int64_t times = number(1, (1 << 12) / v[3]), turn = number(0, 2);
    Place away;
    for (int i = 0; i < 3; ++i) away[std::size_t((i + turn) % 3)] = (number(0, 1) ? 1 : -1) * times * v[i];
    length = times * v[3];
    return away;
}

TerrainShape::TerrainShape(TerrainDraw& draw, bool fine)
    : columns(std::uint32_t(draw.number(2, 5))), rows(std::uint32_t(draw.number(2, 5))),
      heights(std::size_t(columns) * rows), hole(heights.size()), falling(std::size_t(columns - 1) * (rows - 1))
{
    // Normals whose upward component is a power of two, so that slopes are multiples of 1/8.
    static constexpr Place normals[] = {{0, 0, 1},  {3, 0, 4},  {0, -3, 4}, {-15, 0, 8}, {1, 2, 2},
                                        {-2, 1, 2}, {1, -8, 4}, {4, 7, 4},  {9, 12, 8}};
    const std::int64_t way = fine ? 3 : draw.number(0, 3);
    if (way == 0) normal = normals[draw.number(0, 8)];
    const std::int64_t at_x = draw.number(0, columns - 1), at_y = draw.number(0, rows - 1),
                       up = draw.number(0, 1) ? 1 : -1;
    for (std::int64_t row = 0; row < rows; ++row)
        for (std::int64_t column = 0; column < columns; ++column) {
            std::int64_t& height = heights[std::size_t(row * columns + column)];
            if (way == 0)
                height = -width * (normal[0] * column + normal[1] * row) / normal[2];
            else if (way == 1) // a peak or a pit
                height = -up * width / 2 * (std::abs(column - at_x) + std::abs(row - at_y));
            else if (way == 2) // steps
                height = width / 4 * draw.number(0, 2) * up;
            else
                height = fine ? draw.number(0, 4 * width) : width / 8 * draw.number(0, 16);
        }
    for (std::size_t i = 0; i < falling.size(); ++i) falling[i] = draw.one_in(2);
    if (columns > 2 && draw.one_in(3)) hole[std::size_t(draw.number(0, std::int64_t(heights.size()) - 1))] = true;
    if (triangles().empty()) hole.assign(hole.size(), false);
}

std::vector<PlaceTriangle> TerrainShape::triangles() const
{
    std::vector<PlaceTriangle> all;
    for (std::uint32_t y = 0; y + 1 < rows; ++y)
        for (std::uint32_t x = 0; x + 1 < columns; ++x) {
            const std::uint32_t first = y * columns + x;
            if (hole[first] || hole[first + 1] || hole[first + columns] || hole[first + columns + 1]) continue;
            const Place a = point(x, y), b = point(x + 1, y), c = point(x, y + 1), d = point(x + 1, y + 1);
            if (falling[y * (columns - 1) + x])
                all.push_back({a, b, c}), all.push_back({b, d, c});
            else
                all.push_back({a, b, d}), all.push_back({a, d, c});
        }
    return all;
}

Place TerrainShape::feature(TerrainDraw& draw) const
{
    const std::vector<PlaceTriangle> all = triangles();
    const PlaceTriangle& t = all[std::size_t(draw.number(0, std::int64_t(all.size()) - 1))];
    const std::int64_t first = draw.number(0, 2);
    std::array<std::int64_t, 3> weights{4, 0, 0}; // a corner
    const std::int64_t what = draw.number(0, 2);
    if (what == 1) weights = {2, 2, 0};
    if (what == 2) weights = {2, 1, 1};
    Place p{};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < 3; ++i) p[i] += weights[k] * t[std::size_t(first + std::int64_t(k)) % 3][i];
    for (std::int64_t& x : p) x = x >= 0 ? x / 4 : -(-x / 4);
    return p;
}

Terrain TerrainShape::made(double unit, const Place& origin, int bytes, double off_by) const
{
    TerrainGrid grid{.columns = columns, .rows = rows};
    grid.spacing = {unit * double(width), unit * double(width)};
    for (int i = 0; i < 3; ++i) grid.origin[i] = unit * double(origin[std::size_t(i)]);
    grid.no_data = std::numeric_limits<double>::quiet_NaN(), grid.bytes = bytes, grid.falling = falling;
    grid.error = off_by * unit;
    std::vector<double> metres;
    for (std::size_t i = 0; i < heights.size(); ++i) {
        const double sign = i % 3 == 0 ? 1 : i % 3 == 1 ? -1 : 0;
        metres.push_back(hole[i] ? *grid.no_data : unit * (double(heights[i]) + sign * off_by));
    }
    return make_terrain("terrain", grid, metres);
}

} // namespace oncollide::tools
