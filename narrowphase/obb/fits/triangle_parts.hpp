#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Divides the triangles of one box of an ObbTree into the parts that get boxes of their own. Each cut minimises the
/// sum over both sides of box area times number of triangles, with at least two fifths of the triangles on either side.
/// The parts do not depend on the input order of the triangles. Working memory.
class TriangleParts {
public:
    /// The triangles of a mesh, and their numbers in its file if they are numbered differently here.
    struct Source {
        const Eigen::Vector3d* vertices;
        const Triangle* triangles;
        const std::uint32_t* numbers = nullptr;
    };
    /// Starts with these triangles. Coordinates are relative to the centre.
    void start(const Source& mesh, const Eigen::Vector3d& centre, std::span<const std::uint32_t> triangles);
    /// Sorts the triangles into at most eight parts, none of them empty.
    void split(unsigned parts);
    /// Part k is [end(k - 1), end(k)) of the resulting order.
    std::size_t end(unsigned k) const { return ends_[k]; }

    /// Indexed by the current order.
    std::uint32_t triangle(std::size_t i) const { return triangles_[items_[i].number]; }
    const TrianglePoints& corners(std::size_t i) const { return corners_[items_[i].number]; }
    /// Bounds of the triangles in [from, to), as floats.
    Aabb bounds(std::size_t from, std::size_t to) const;

    static const std::size_t bytes_each; ///< per triangle

private:
    struct Item {
        std::array<float, 3> place; ///< three times the triangle's centre
        std::uint32_t number;       ///< position in the input
    };
    /// An axis-aligned box in the mesh's frame. The fourth lanes are 0.
    struct Bounds {
        Eigen::Array4f low, high;
    };
    struct Growing;
    /// A division of the items: the first `at` of them along the axis, and the others.
    struct Cut {
        int axis;
        std::size_t at;
        float cost;              ///< sum over both sides of box area times number of triangles
        std::uint32_t slice = 0; ///< first slice of the second side, if it is a cut between Slices; else 0
    };
    /// Slices across an axis along which coordinates are in [low, high].
    struct Slices {
        int axis;
        float low, high;
        std::uint32_t number = few;

        static constexpr std::uint32_t few = 32;
        std::uint32_t of(const Item& item) const
        {
            const float along = item.place[static_cast<std::size_t>(axis)] - low;
            return std::min(static_cast<std::uint32_t>(along * (float(number) / (high - low))), number - 1);
        }
    };
    static constexpr std::size_t most_sorted = 64; ///< items
    using Order = std::array<std::uint8_t, most_sorted>;

    void split(std::span<Item> items, unsigned parts, std::size_t begin, unsigned first);
    bool before(const Item& x, const Item& y, int axis) const;
    bool before_in_a_tie(const Item& x, const Item& y, int axis) const;
    void sort(std::span<const Item> items, int axis, Order& order) const;
    Cut best_of_few(std::span<const Item> items, std::size_t least, std::size_t most, int axis,
                    const Order& order) const;
    Cut best_of_slices(std::span<const Item> items, std::size_t least, std::size_t most, const Growing& places,
                       const std::array<bool, 3>& axes) const;
    static void try_slices(std::span<const Bounds> bounds, std::span<const std::uint32_t> counts, int axis,
                           std::size_t size, std::size_t least, std::size_t most, Cut& best);
    void part(std::span<Item> items, auto first);
    void arrange(std::span<Item> items, const Order& order);
    void halve(std::span<Item> items, std::size_t half, const Slices& slices);

    std::vector<Item> items_, above_; ///< above_: scratch
    std::vector<Bounds> bounds_;      ///< by Item::number, as the next two
    std::vector<TrianglePoints> corners_;
    std::vector<std::uint32_t> triangles_; ///< numbers in the mesh
    const std::uint32_t* numbers_ = nullptr;
    std::array<std::size_t, 8> ends_;
};

} // namespace oncollide
