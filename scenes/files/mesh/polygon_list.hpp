#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

/// Polygons with their lines in the file, until all vertices are known. Private to scenes.
class PolygonList {
public:
    void reserve(std::size_t triangles);
    /// @param corners numbers of vertices, as in the file or counted from 0
    /// @param line    0: the file has no lines
    void add(std::span<const std::int64_t> corners, std::size_t line)
    {
        const auto fits = [](std::int64_t corner) { return static_cast<std::uint64_t>(corner) < most_corners; };
        if (corners.size() != 3 || !fits(corners[0]) || !fits(corners[1]) || !fits(corners[2]))
            return add_polygon(corners, line);
        const auto corner = [&](std::size_t k) { return static_cast<std::uint32_t>(corners[k]); };
        add({corner(0), corner(1), corner(2)}, line);
    }
    void add(const Triangle& triangle, std::size_t line)
    {
        note(line);
        append_large(triangles_, triangle);
    }

    /// The number of triangles into which the polygons will be divided.
    std::size_t triangle_count() const { return triangles_.size() + corners_.size() - 2 * polygons_.size(); }

    /// Appends triangles of a file without lines: `fill` writes up to `most` triangles and returns their number.
    template <class Fill>
    std::size_t add_many(std::size_t most, Fill fill)
    {
        const std::size_t before = triangles_.size();
        triangles_.resize(before + most);
        const std::size_t count = fill(triangles_.data() + before);
        triangles_.resize(before + count);
        return count;
    }

    /// Returns the triangles of all polygons, in order, and clears the list. Throws for an index out of range, given in
    /// the file's numbering, which starts at `first`.
    std::vector<Triangle> triangulate(const MeshSource& source, std::span<const Eigen::Vector3d> vertices,
                                      std::int64_t first);

private:
    /// A polygon with more than three corners, or with a corner that no mesh can have.
    struct Polygon {
        std::size_t triangles; ///< number of triangles before it
        std::size_t begin;     ///< index of its first corner
    };
    /// Beginning with `polygon`, each polygon is on the line after the previous one, as in most files.
    struct Run {
        std::size_t polygon, line;
    };

    static constexpr std::uint64_t most_corners = 0xffffffff;

    void add_polygon(std::span<const std::int64_t> corners, std::size_t line);
    std::size_t size() const { return triangles_.size() + polygons_.size(); }
    void note(std::size_t line)
    {
        if (line == 0) return;
        if (runs_.empty() || line - runs_.back().line != size() - runs_.back().polygon) runs_.push_back({size(), line});
    }
    std::size_t line_of(std::size_t polygon) const;
    void check(const MeshSource& source, std::span<const std::int64_t> corners, std::size_t polygon,
               std::size_t vertices, std::int64_t first) const;

    std::vector<Triangle> triangles_;
    std::vector<Polygon> polygons_;
    std::vector<std::int64_t> corners_; ///< corners of the polygons
    std::vector<Run> runs_;
};

/// Appends the triangles of one polygon: a fan from the first corner if it is convex, else by ear clipping. Zero areas
/// are kept. False if it is not convex and has more corners than `most_concave_corners`.
constexpr std::size_t most_concave_corners = 4096;
bool triangulate(std::span<const Eigen::Vector3d> vertices, std::span<const std::uint32_t> polygon,
                 std::vector<Triangle>& triangles);

} // namespace oncollide
