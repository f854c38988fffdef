// Simple baselines: every pair, and a uniform grid rebuilt each frame.
#include "peers/peers.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace oncollide::tools {
namespace {

class BrutePeer final : public BroadPeer {
public:
    void start(const BoxFrame&) override {}

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        pairs.clear();
        for (std::uint32_t a = 0; a < frame.boxes.size(); ++a)
            for (std::uint32_t b = a + 1; b < frame.boxes.size(); ++b)
                if (!(frame.is_static[a] && frame.is_static[b]) && frame.boxes[a].overlaps(frame.boxes[b]))
                    pairs.push_back({a, b});
    }
};

/// Each box is listed in every cell that it overlaps. Two boxes are compared in the lists of all their common cells,
/// and reported in the cell that holds the lower corner of their intersection.
class GridPeer final : public BroadPeer {
public:
    void start(const BoxFrame&) override {}

    void step(const BoxFrame& frame, std::vector<BodyPair>& pairs) override
    {
        pairs.clear();
        choose_cells(frame.boxes);
        fill_cells(frame.boxes);
        for (std::size_t cell = 0; cell + 1 < first_.size(); ++cell)
            for (std::size_t i = first_[cell]; i < first_[cell + 1]; ++i)
                for (std::size_t j = i + 1; j < first_[cell + 1]; ++j) compare(frame, cell, list_[i], list_[j], pairs);
    }

private:
    using Cell = std::array<std::size_t, 3>;

    /// Cells as large as the mean box, but at most two cells per box.
    void choose_cells(std::span<const Aabb> boxes)
    {
        Aabb world;
        double edges = 0;
        for (const Aabb& box : boxes) {
            world.add(box);
            edges += (box.max - box.min).maxCoeff();
        }
        origin_ = world.min;
        const Eigen::Vector3d extent = world.max - world.min;
        const double n = std::max<double>(1, double(boxes.size()));
        for (double edge = std::max(edges / n, 1e-9 * extent.maxCoeff() + 1e-300);; edge *= 1.1) {
            const Eigen::Vector3d counts = (extent / edge).array().floor() + 1;
            if (counts.prod() > 2 * n + 1) continue;
            per_metre_ = 1 / edge;
            for (int axis : {0, 1, 2}) cells_[std::size_t(axis)] = std::size_t(counts[axis]);
            return;
        }
    }

    Cell cell_of(const Eigen::Vector3d& point) const
    {
        Cell cell;
        for (std::size_t axis : {0, 1, 2}) {
            const double at = (point[Eigen::Index(axis)] - origin_[Eigen::Index(axis)]) * per_metre_;
            cell[axis] = std::min(std::size_t(at), cells_[axis] - 1);
        }
        return cell;
    }

    std::size_t number(std::size_t x, std::size_t y, std::size_t z) const
    {
        return (z * cells_[1] + y) * cells_[0] + x;
    }

    template <class Visit>
    void for_cells(const Aabb& box, Visit visit) const
    {
        const Cell low = cell_of(box.min), high = cell_of(box.max);
        for (std::size_t z = low[2]; z <= high[2]; ++z)
            for (std::size_t y = low[1]; y <= high[1]; ++y)
                for (std::size_t x = low[0]; x <= high[0]; ++x) visit(number(x, y, z));
    }

    /// Counting sort of the boxes by cell.
    void fill_cells(std::span<const Aabb> boxes)
    {
        first_.assign(cells_[0] * cells_[1] * cells_[2] + 1, 0);
        for (const Aabb& box : boxes) for_cells(box, [&](std::size_t cell) { ++first_[cell]; });
        std::size_t sum = 0;
        for (std::size_t& n : first_) sum += n, n = sum; // ends; the loop below turns them into starts
        list_.resize(sum);
        for (std::uint32_t i = std::uint32_t(boxes.size()); i-- > 0;)
            for_cells(boxes[i], [&](std::size_t cell) { list_[--first_[cell]] = i; });
    }

    void compare(const BoxFrame& frame, std::size_t cell, std::uint32_t a, std::uint32_t b,
                 std::vector<BodyPair>& pairs) const
    {
        const Aabb &p = frame.boxes[a], &q = frame.boxes[b];
        if (!p.overlaps(q) || (frame.is_static[a] && frame.is_static[b])) return;
        const Cell home = cell_of(p.min.cwiseMax(q.min));
        if (number(home[0], home[1], home[2]) == cell) pairs.push_back({a, b});
    }

    Eigen::Vector3d origin_;
    double per_metre_ = 0;
    Cell cells_{};
    std::vector<std::size_t> first_;  ///< by cell, its first index in list_; one more at the end
    std::vector<std::uint32_t> list_; ///< boxes
};

} // namespace

std::unique_ptr<BroadPeer> make_grid_peer()
{
    return std::make_unique<GridPeer>();
}
std::unique_ptr<BroadPeer> make_brute_peer()
{
    return std::make_unique<BrutePeer>();
}

void add_baselines(Contenders& all)
{
    all.broad.all.push_back(
        {.name = "grid", .what = "uniform grid, rebuilt", .group = Group::baseline, .make = [](int) {
             return make_grid_peer();
         }});
    all.broad.all.push_back(
        {.name = "brute", .what = "every pair", .group = Group::baseline, .most = 10'000, .make = [](int) {
             return make_brute_peer();
         }});
}

} // namespace oncollide::tools
