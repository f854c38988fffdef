#include <oncollide/narrowphase/obb/fits/grid_split.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace oncollide {

namespace {

using Eigen::Array3d;
using Eigen::Vector3d;

constexpr std::uint32_t few = 4096; ///< parts of at most this many triangles are not divided
constexpr std::uint32_t most_cells = 1u << 16;

/// A box of cells: [low, high) along each axis.
struct CellRange {
    std::array<int, 3> low, high;
    bool one() const { return high[0] - low[0] == 1 && high[1] - low[1] == 1 && high[2] - low[2] == 1; }
};

class Grid {
public:
    explicit Grid(const Aabb& around) : origin_(around.min)
    {
        const Vector3d size = around.max - around.min;
        side_ = std::max(size.maxCoeff() / 1024, 1e-300);
        const auto cells = [&] {
            double product = 1;
            for (int axis = 0; axis < 3; ++axis) product *= std::floor(size[axis] / side_) + 1;
            return product;
        };
        while (cells() > most_cells) side_ *= 1.05;
        for (int axis = 0; axis < 3; ++axis) dims_[std::size_t(axis)] = static_cast<int>(size[axis] / side_) + 1;
        counts_.resize(std::size_t(dims_[0]) * std::size_t(dims_[1]) * std::size_t(dims_[2]));
        boxes_.resize(counts_.size());
        part_of_.resize(counts_.size());
    }
    CellRange all() const { return {{0, 0, 0}, dims_}; }
    std::uint32_t count(const CellRange& range) const
    {
        std::uint32_t sum = 0;
        each(range, [&](std::size_t cell) { sum += counts_[cell]; });
        return sum;
    }
    /// Counts a triangle in the cell that contains its centre. Returns the cell.
    std::uint16_t add(const std::array<Vector3d, 3>& corners)
    {
        const Vector3d middle = (corners[0] + corners[1] + corners[2]) / 3;
        std::array<int, 3> at;
        for (std::size_t i = 0; i < 3; ++i) {
            const double place = (middle[Eigen::Index(i)] - origin_[Eigen::Index(i)]) / side_;
            at[i] = static_cast<int>(std::clamp(place, 0.0, double(dims_[i] - 1)));
        }
        const std::size_t cell = index(at[0], at[1], at[2]);
        ++counts_[cell];
        Aabb box; // the cell's box changes once per triangle, because the next triangle waits for the change
        for (const Vector3d& p : corners) box.add(p);
        boxes_[cell].min = boxes_[cell].min.cwiseMin(box.min), boxes_[cell].max = boxes_[cell].max.cwiseMax(box.max);
        return static_cast<std::uint16_t>(cell);
    }
    /// Halves the range near the median of its triangles, along the longest side that can be cut. Returns false if none
    /// can.
    bool halve(const CellRange& range, CellRange& first, CellRange& second) const
    {
        std::array<std::size_t, 3> axes{0, 1, 2};
        std::ranges::stable_sort(axes, [&](std::size_t x, std::size_t y) {
            return range.high[x] - range.low[x] > range.high[y] - range.low[y];
        });
        for (const std::size_t axis : axes) {
            std::vector<std::uint32_t> slices(std::size_t(range.high[axis] - range.low[axis]));
            for (int z = range.low[2]; z < range.high[2]; ++z)
                for (int y = range.low[1]; y < range.high[1]; ++y)
                    for (int x = range.low[0]; x < range.high[0]; ++x)
                        slices[std::size_t(std::array{x, y, z}[axis] - range.low[axis])] += counts_[index(x, y, z)];
            const std::uint32_t all = std::accumulate(slices.begin(), slices.end(), 0u);
            std::uint32_t before = 0, best = 0;
            int at = 0;
            for (std::size_t k = 0; k + 1 < slices.size(); ++k) {
                before += slices[k];
                if (std::min(before, all - before) > best)
                    best = std::min(before, all - before), at = range.low[axis] + int(k) + 1;
            }
            if (best < all / 8) continue;
            first = second = range;
            first.high[axis] = second.low[axis] = at;
            return true;
        }
        return false;
    }
    void name(const CellRange& range, std::uint32_t part)
    {
        each(range, [&](std::size_t cell) { part_of_[cell] = part; });
    }
    std::uint32_t part_of(std::uint16_t cell) const { return part_of_[cell]; }
    Aabb box(const CellRange& range) const
    {
        Aabb box;
        each(range, [&](std::size_t cell) {
            if (counts_[cell]) box.add(boxes_[cell].min), box.add(boxes_[cell].max);
        });
        return box;
    }

private:
    std::size_t index(int x, int y, int z) const
    {
        return (std::size_t(z) * std::size_t(dims_[1]) + std::size_t(y)) * std::size_t(dims_[0]) + std::size_t(x);
    }
    void each(const CellRange& range, auto visit) const
    {
        for (int z = range.low[2]; z < range.high[2]; ++z)
            for (int y = range.low[1]; y < range.high[1]; ++y)
                for (int x = range.low[0]; x < range.high[0]; ++x) visit(index(x, y, z));
    }

    Vector3d origin_;
    double side_;
    std::array<int, 3> dims_;
    std::vector<std::uint32_t> counts_; ///< by cell
    std::vector<Aabb> boxes_;           ///< bounds of the triangles in a cell
    std::vector<std::uint32_t> part_of_;
};

/// Divides ranges, and numbers the ranges that are not divided further.
class Divider {
public:
    Divider(Grid& grid, std::uint32_t begin) : grid_(grid), next_(begin) {}

    GridPart part(const CellRange& range, std::uint32_t count)
    {
        GridPart part{next_, count, {}, {}};
        std::vector<CellRange> lanes;
        if (count > few) divide(range, 8, lanes);
        if (lanes.size() < 2) {
            grid_.name(range, static_cast<std::uint32_t>(begins.size()));
            begins.push_back(next_), next_ += count;
            part.box = grid_.box(range);
            return part;
        }
        for (const CellRange& lane : lanes) {
            part.parts.push_back(this->part(lane, grid_.count(lane)));
            part.box.add(part.parts.back().box.min), part.box.add(part.parts.back().box.max);
        }
        return part;
    }

    std::vector<std::uint32_t> begins; ///< first positions of the undivided ranges

private:
    void divide(const CellRange& range, int lanes, std::vector<CellRange>& out) const
    {
        CellRange first, second;
        if (lanes == 1 || !grid_.halve(range, first, second)) return out.push_back(range);
        divide(first, lanes / 2, out), divide(second, lanes / 2, out);
    }

    Grid& grid_;
    std::uint32_t next_;
};

} // namespace

GridPart split_by_grid(const Mesh& mesh, const Vector3d& centre, std::span<std::uint32_t> triangles, const Aabb& around)
{
    Grid grid(around);
    std::vector<std::uint16_t> cells(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[triangles[i]];
        cells[i] = grid.add({mesh.vertices[t[0]] - centre, mesh.vertices[t[1]] - centre, mesh.vertices[t[2]] - centre});
    }
    Divider divider(grid, 0);
    const GridPart all = divider.part(grid.all(), static_cast<std::uint32_t>(triangles.size()));
    const std::vector<std::uint32_t> before(triangles.begin(), triangles.end());
    std::vector<std::uint32_t> next = divider.begins;
    for (std::size_t i = 0; i < before.size(); ++i) triangles[next[grid.part_of(cells[i])]++] = before[i];
    return all;
}

} // namespace oncollide
