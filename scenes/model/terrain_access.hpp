#pragma once
#include <limits>
#include <type_traits>
#include <variant>

#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

/// Terrain's arithmetic inline, for the library's own loops. The public header has only declarations: a program could
/// compile inline arithmetic with -ffast-math, and the linker could then give that code to the library.
struct TerrainAccess {
    static double x(const Terrain& t, std::uint32_t column) { return t.origin_.x() + column * t.spacing_.x(); }
    static double y(const Terrain& t, std::uint32_t row) { return t.origin_.y() + row * t.spacing_.y(); }
    static Eigen::Vector3d point(const Terrain& t, std::uint32_t column, std::uint32_t row)
    {
        return {x(t, column), y(t, row), t.origin_.z() + height(t, column, row)};
    }
    static double height(const Terrain& t, std::uint32_t column, std::uint32_t row)
    {
        if (t.chunks_) return t.height_in_chunk(column, row);
        return std::visit([&](const auto& samples) { return height(t, samples, column, row); }, t.samples_);
    }
    /// Calls work(decode), where decode(column, row) is height(): chooses the storage type once for several heights.
    template <class Work>
    static void with_heights(const Terrain& t, Work work)
    {
        if (t.chunks_)
            return work([&](std::uint32_t column, std::uint32_t row) { return t.height_in_chunk(column, row); });
        std::visit(
            [&](const auto& samples) {
                work([&](std::uint32_t column, std::uint32_t row) { return height(t, samples, column, row); });
            },
            t.samples_);
    }

private:
    template <class Sample>
    static double height(const Terrain& t, const LargeVector<Sample>& samples, std::uint32_t column, std::uint32_t row)
    {
        constexpr std::uint32_t tile = Terrain::tile;
        const std::size_t number = std::size_t(row / tile) * t.tiles_x_ + column / tile;
        const Sample q = samples[number * (tile * tile) + row % tile * tile + column % tile];
        if constexpr (std::is_floating_point_v<Sample>) {
            return q;
        } else {
            if (q == std::numeric_limits<Sample>::max()) return std::numeric_limits<double>::quiet_NaN();
            return t.unit_ * static_cast<double>(t.tiles_[number].at(q));
        }
    }
};

} // namespace oncollide
