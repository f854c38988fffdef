#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include <oncollide/base/memory/once.hpp>
#include <oncollide/robots/clearances.hpp>

namespace oncollide {

/// Pairs of parts between which one to three numbers act: the pose of one part relative to the other depends on these
/// numbers alone. A coarse and a fine grid over the numbers store where a pair is certainly apart. A cell is tested
/// when an edge first needs it, and then serves all edges: contents depend on the robot and the clearances alone. A
/// fine grid takes up to 70 kB. Calls from many threads are safe.
class JointCells {
public:
    JointCells(const Robot::Impl& robot, double clearance);

    double clearance() const { return clearances_.of_world(); }
    bool covers(std::uint32_t pair) const { return !grids_[pair].axes.empty(); }

    /// Memory for the tests of cells; each thread needs its own.
    struct Scratch {
        std::vector<double> from, middle, to;
        std::vector<Eigen::Isometry3d> links;
    };
    /// Calls add(begin, end) for the windows of an edge in which a covered pair may meet.
    template <class Add>
    void each_open(const World& world, std::uint32_t pair, const double* from, const double* to, Scratch& scratch,
                   Add add)
    {
        const Edge edge = edge_of(pair, from, to);
        // The search returns true if no part is known to be apart.
        const auto search = [&](auto& self, double begin, double end, bool is_tested) -> bool {
            const double width = edge.width * (end - begin);
            if (!is_tested && width <= 1) {
                if (is_clear(world, edge, coarse, 0.5 * (begin + end), scratch)) return false;
                is_tested = true;
            }
            const double in_fine = width * static_cast<double>(grids_[pair].cells[fine].per_step);
            if (in_fine <= 1) return !is_clear(world, edge, fine, 0.5 * (begin + end), scratch);
            if (end - begin <= shortest) return true;
            const double middle = 0.5 * (begin + end);
            const bool first = self(self, begin, middle, is_tested), second = self(self, middle, end, is_tested);
            if (first && second) return true;
            if (first) add(begin, middle);
            if (second) add(middle, end);
            return false;
        };
        if (search(search, 0, 1, false)) add(0, 1);
    }

private:
    static constexpr std::size_t most_axes = 3;
    static constexpr double shortest = 1.0 / 128; ///< window
    /// A number, in steps: the widths of coarse cells.
    struct Axis {
        std::uint32_t number;
        double low, step;
        bool is_periodic;
    };
    enum Level { coarse, fine };
    /// Cells of two bits each.
    struct Cells {
        std::int64_t per_step = 1; ///< along an axis: a power of two
        OnceFlag made;
        std::unique_ptr<std::atomic<std::uint64_t>[]> words;
        std::size_t count = 0;
    };
    struct Grid {
        std::vector<Axis> axes;
        std::unique_ptr<Cells[]> cells; ///< by level
    };
    struct Edge {
        std::uint32_t pair;
        double width; ///< the most steps that a number moves
        std::array<double, most_axes> from, way;
    };
    using Cell = std::array<std::int64_t, most_axes>;

    Grid grid_of(const Robot::Impl::PartPair& pair) const;
    Edge edge_of(std::uint32_t pair, const double* from, const double* to) const;
    /// True if the pair is certainly apart in a window around a share of the edge, no wider than a cell of the level.
    bool is_clear(const World& world, const Edge& edge, Level level, double share, Scratch& scratch);
    bool are_apart(const World& world, std::uint32_t pair, double per_step, const Cell& cell, Scratch& scratch) const;

    const Robot::Impl& robot_;
    const Clearances clearances_;
    std::vector<Grid> grids_; ///< by pair
};

} // namespace oncollide
