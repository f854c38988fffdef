#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

// Building blocks of generated meshes. Private to scenes.

/// Cosine and sine of 2 pi `turns` (>= 0). Plain arithmetic: equal bits on every platform, which the C library does not
/// guarantee; exact at the quarters and symmetric about them.
struct Circle {
    double cosine, sine;
};
Circle circle(double turns);

/// The octahedron's faces cut into frequency^2 triangles each, every vertex moved to the unit sphere. Vertices on the
/// three coordinate planes have an exact zero there. Outward orientation.
void octasphere(int frequency, std::vector<Eigen::Vector3d>& points, std::vector<Triangle>& triangles);

/// A grid of columns x rows quads on a surface, cut into triangles. Along a closed direction the last quads share
/// vertices with the first: at(columns, j) == at(0, j). Triangles face along du x dv.
class GridBuilder {
public:
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;

    GridBuilder(int columns, int rows, bool closed_rows, bool closed_columns = true)
        : columns_(columns), rows_(rows), point_columns_(columns + !closed_columns), point_rows_(rows + !closed_rows)
    {
    }

    std::uint32_t at(int column, int row) const
    {
        return static_cast<std::uint32_t>(row % point_rows_) * static_cast<std::uint32_t>(point_columns_) +
               static_cast<std::uint32_t>(column % point_columns_);
    }

    /// @param extra  this many quads, spread evenly, become four triangles around point(centre) instead of two, to
    ///               reach an exact number of triangles; at most columns * rows
    /// @param point  maps (column, row), integers at the corners, to the surface
    template <class Point>
    void build(int extra, Point point)
    {
        points.reserve(static_cast<std::size_t>(point_columns_) * point_rows_ + extra + 2);
        for (int j = 0; j < point_rows_; ++j)
            for (int i = 0; i < point_columns_; ++i) points.push_back(point(i, j));
        triangles.reserve(2 * static_cast<std::size_t>(columns_) * rows_ + 2 * static_cast<std::size_t>(extra));
        const std::int64_t quads = std::int64_t(columns_) * rows_;
        for (int j = 0; j < rows_; ++j)
            for (int i = 0; i < columns_; ++i) {
                const std::int64_t quad = std::int64_t(j) * columns_ + i;
                // True for exactly `extra` of the numbers below `quads`.
                const bool split = (quad + 1) * extra / quads != quad * extra / quads;
                if (split) points.push_back(point(i + 0.5, j + 0.5));
                add_quad(i, j, split);
            }
    }

private:
    void add_quad(int i, int j, bool split)
    {
        const std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
        if (!split) {
            triangles.push_back({a, b, c}), triangles.push_back({a, c, d});
            return;
        }
        const auto centre = static_cast<std::uint32_t>(points.size() - 1);
        for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, d}, {d, a}})
            triangles.push_back({from, to, centre});
    }

    int columns_, rows_, point_columns_, point_rows_;
};

/// A box with corners +-half, as 12 triangles with outward orientation.
Mesh box_mesh(const Eigen::Vector3d& half);

/// A closed prism along z, from -half to half, whose corners are on a circle of that radius; its caps are fans.
Mesh make_prism(const std::string& name, double radius, double half, int sides);

} // namespace oncollide
