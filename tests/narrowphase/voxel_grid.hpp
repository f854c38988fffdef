// A minimal hierarchy for tests: cubes of a regular grid, as an implicit octree, and their tests against triangles.
// The box traversal needs no more for a new kind of geometry.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_gap.hpp>
#include <oncollide/narrowphase/obb/hierarchy.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide {

/// Unit cubes times `cell`; some of size^3, a power of two, with a corner at the origin.
class VoxelGrid {
public:
    struct Node {
        std::uint32_t size, x, y, z; ///< cubes per side, and the first cube
    };
    using Primitive = std::uint32_t; ///< (z size + y) size + x
    static constexpr Node root{0, 0, 0, 0};

    VoxelGrid(std::uint32_t size, double cell, auto occupied) : size_(size), cell_(cell)
    {
        for (std::uint32_t i = 0; i < size * size * size; ++i)
            if (occupied(i % size, i / size % size, i / size / size)) cubes_.push_back(i);
    }
    const std::vector<std::uint32_t>& cubes() const { return cubes_; }
    Eigen::Vector3d centre() const { return Eigen::Vector3d::Constant(0.5 * size_ * cell_); }
    double radius() const { return 0.5 * size_ * cell_ * 1.7320508075688774; }

    LaneMasks open(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const
    {
        LaneMasks masks{0, 0};
        boxes.margin = box_margin * static_cast<float>(1.5 * cell_ * (node.size ? node.size / 2 : size_));
        const bool rotated = placement && placement->rotated;
        for (unsigned k = 0; k < 8; ++k) {
            const Node part = below(node, k);
            const bool any = (node.size || k == 0) && holds(part);
            const float half = any ? static_cast<float>(0.5 * part.size * cell_ * (1 + 0x1p-20)) : 0;
            const Eigen::Vector3d low(part.x, part.y, part.z);
            Eigen::Vector3d middle = cell_ * (low.array() + 0.5 * part.size).matrix() - centre();
            if (placement) middle -= Eigen::Map<const Eigen::Vector3f>(placement->from).cast<double>();
            for (int i = 0; i < 3; ++i) {
                float c = rotated ? placement->translation[i] : static_cast<float>(middle[i]);
                for (int j = 0; j < 3; ++j) {
                    if (rotated) c += placement->rotation[3 * i + j] * static_cast<float>(middle[j]);
                    boxes.axis[j][i][k] = rotated ? placement->rotation[3 * i + j] : i == j;
                }
                boxes.c[i][k] = any ? c : 1e30f;
                boxes.h[i][k] = half;
            }
            boxes.size[k] = 3 * half * half;
            masks.leaves |= unsigned(part.size == 1) << k;
        }
        masks.singles = masks.leaves;
        return masks;
    }
    Node child(const Node& node, unsigned k) const { return below(node, k); }
    auto primitives(const Node& node, unsigned k) const
    {
        const Node cube = below(node, k);
        return std::array{(cube.z * size_ + cube.y) * size_ + cube.x};
    }

    /// The corners of a cube: bit 0 of the number is x, bit 1 y, bit 2 z.
    std::array<Eigen::Vector3d, 8> corners(std::uint32_t cube) const
    {
        std::array<Eigen::Vector3d, 8> points;
        for (std::uint32_t k = 0; k < 8; ++k)
            points[k] = cell_ * Eigen::Vector3d(cube % size_ + (k & 1), cube / size_ % size_ + (k >> 1 & 1),
                                                cube / size_ / size_ + (k >> 2));
        return points;
    }

private:
    /// The root has one box, around the whole grid.
    Node below(const Node& node, unsigned k) const
    {
        if (!node.size) return {size_, 0, 0, 0};
        const std::uint32_t half = node.size / 2;
        return {half, node.x + (k & 1) * half, node.y + (k >> 1 & 1) * half, node.z + (k >> 2) * half};
    }
    bool holds(const Node& node) const
    {
        return std::ranges::any_of(cubes_, [&](std::uint32_t i) {
            const std::uint32_t x = i % size_, y = i / size_ % size_, z = i / size_ / size_;
            return x - node.x < node.size && y - node.y < node.size && z - node.z < node.size;
        });
    }

    std::uint32_t size_;
    double cell_;
    std::vector<std::uint32_t> cubes_;
};

/// A solid cube against a triangle, with B transformed into A's frame; `cubes_first`: the grid is A.
template <bool cubes_first>
class CubeTests {
public:
    struct Pair {
        std::uint32_t a, b;
        friend auto operator<=>(const Pair&, const Pair&) = default;
    };
    using A = std::conditional_t<cubes_first, VoxelGrid, ObbTree>;
    using B = std::conditional_t<cubes_first, ObbTree, VoxelGrid>;

    void start(const A& a, const B& b, const RelativePose& b_to_a)
    {
        a_ = &a, b_ = &b, b_to_a_ = &b_to_a;
        least_ = std::numeric_limits<double>::infinity();
    }
    bool meeting(std::span<const Pair> pairs, auto found)
    {
        for (const Pair& pair : pairs) {
            ++tested;
            if (!meet(pair))
                least_ = std::min(least_, gap(pair));
            else if (!found(pair))
                return false;
        }
        return true;
    }
    double least_gap(double) const { return least_; }
    bool meet(const Pair& pair) const
    {
        const TrianglePoints t = triangle(pair);
        bool inside = true;
        for (const TrianglePoints& face : faces(pair)) {
            if (triangles_meet(face, t)) return true;
            inside &= orient3d(face[0], face[1], face[2], t[0]) < 0;
        }
        return inside;
    }
    NearestPoints nearest(const Pair& pair, double rounding) const
    {
        const TrianglePoints t = triangle(pair);
        NearestPoints least{{}, {}, std::numeric_limits<double>::infinity()};
        for (const TrianglePoints& face : faces(pair)) {
            const NearestPoints points =
                cubes_first ? nearest_points(face, t, rounding) : nearest_points(t, face, rounding);
            if (points.distance < least.distance) least = points;
        }
        return least;
    }
    double high_a(std::uint32_t a, const Eigen::Vector3d& line) const
    {
        double high = -std::numeric_limits<double>::infinity();
        const auto look = [&](const auto& points) {
            for (const Eigen::Vector3d& p : points) high = std::max(high, line.dot(p));
        };
        if constexpr (cubes_first)
            look(a_->corners(a));
        else
            look(triangle({a, 0}));
        return high;
    }
    double low_b(std::uint32_t b, const Eigen::Vector3d& line) const
    {
        double low = std::numeric_limits<double>::infinity();
        for (const Eigen::Vector3d& p : b_->corners(b)) low = std::min(low, line.dot(p));
        return low;
    }
    double most(const Pair& pair) const { return corner_distance(faces(pair)[0], triangle(pair)); }

    std::uint64_t tested = 0;

private:
    double gap(const Pair& pair) const
    {
        double least = std::numeric_limits<double>::infinity();
        for (const TrianglePoints& face : faces(pair)) least = std::min(least, triangle_gap(face, triangle(pair)));
        return least;
    }
    std::array<TrianglePoints, 12> faces(const Pair& pair) const
    {
        std::array<Eigen::Vector3d, 8> p;
        if constexpr (cubes_first) {
            p = a_->corners(pair.a);
        } else {
            p = b_->corners(pair.b);
            for (Eigen::Vector3d& corner : p) corner = (*b_to_a_)(corner);
        }
        constexpr std::uint8_t turns[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                               {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
        std::array<TrianglePoints, 12> all;
        for (std::size_t i = 0; i < 12; ++i) all[i] = {p[turns[i][0]], p[turns[i][1]], p[turns[i][2]]};
        return all;
    }
    TrianglePoints triangle(const Pair& pair) const
    {
        const ObbTree* tree;
        if constexpr (cubes_first)
            tree = b_;
        else
            tree = a_;
        TrianglePoints points;
        for (std::size_t k = 0; k < 3; ++k) {
            points[k] = tree->mesh().vertices[tree->mesh().triangles[cubes_first ? pair.b : pair.a][k]];
            if (cubes_first) points[k] = (*b_to_a_)(points[k]);
        }
        return points;
    }

    const A* a_ = nullptr;
    const B* b_ = nullptr;
    const RelativePose* b_to_a_ = nullptr;
    double least_ = 0;
};

} // namespace oncollide
