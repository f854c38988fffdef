// The directions in which two overlapping bodies face each other.
#pragma once
#include <span>
#include <utility>
#include <vector>

#include <oncollide/narrowphase/pairs/manifolds/overlap_patches.hpp>

namespace oncollide {

/// Numbers of patches of a and of b, and of points of the curve, in a lump or in one direction of a lump.
struct LumpPart {
    std::span<const std::uint32_t> a, b, curve;
};

/// The part of each lump. Keeps its memory between calls.
class LumpParts {
public:
    void set(const OverlapPatches& overlap);
    LumpPart operator[](std::size_t lump) const;

private:
    /// Sorted by lump; lump i begins at offsets[i].
    struct Order {
        std::vector<std::uint32_t> numbers, offsets;
    };
    std::array<Order, 3> orders_; ///< orders of patches of a, of patches of b, and of points of the curve
};

/// A direction in which faces of both bodies are opposite each other.
struct Facing {
    Eigen::Vector3d direction;
    double area_a = 0, area_b = 0;
    Eigen::Vector3d moment_a = Eigen::Vector3d::Zero(), moment_b = Eigen::Vector3d::Zero();

    double matched() const { return std::min(area_a, area_b); }
    /// The distance of the middles of both sides.
    double thickness() const { return std::abs((moment_a / area_a - moment_b / area_b).dot(direction)); }
    void add(const Facing& other)
    {
        area_a += other.area_a, area_b += other.area_b, moment_a += other.moment_a, moment_b += other.moment_b;
    }
};

/// The directions of one lump.
struct LumpFacings {
    std::vector<Facing> all;
    std::vector<std::uint32_t> number; ///< for each direction that PatchFacings found, the one that took it in, or none
};

/// Joins directions within `spread` (radians) of a larger one.
void join_facings(LumpFacings& facings, double spread);

/// Sorts the patches of lumps by directions. Keeps its memory between calls.
class PatchFacings {
public:
    static constexpr std::uint32_t none = ~0u;

    void clear(const OverlapPatches& overlap);
    /// Finds the directions in which both bodies have area, the largest face first. Patches such as the sides of a box
    /// that has sunk into the ground face nothing.
    /// @param spread  radians: faces that differ less from the first of a direction belong to it
    LumpFacings find(const OverlapPatches& overlap, const LumpPart& lump, double spread);
    /// The number of a patch's direction in its lump; none: it faces nothing.
    std::uint32_t of(int side, std::uint32_t patch, const LumpFacings& lump) const
    {
        const std::uint32_t found = found_[side][patch];
        return found == none ? none : lump.number[found];
    }

private:
    std::array<std::vector<std::uint32_t>, 2> found_; ///< for each patch of a and of b, the direction found
    std::vector<std::pair<double, std::uint32_t>> by_area_;
};

} // namespace oncollide
