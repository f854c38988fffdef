#include <oncollide/robots/edges/joint_cells.hpp>

#include <cmath>
#include <limits>
#include <numbers>

#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {

namespace {

constexpr std::int64_t steps = 32;                   // along an axis
constexpr std::int64_t most_fine[] = {64, 16, 2};    // fine cells per step, by the number of axes
constexpr double largest_number = 1e3;               // beyond it, rounding could leave a cell
constexpr double turns_above = 8192 * double(steps); // keeps indices positive before they are taken modulo a turn

enum : std::uint64_t { unknown, clear, open };

} // namespace

JointCells::JointCells(const Robot::Impl& robot, double clearance) : robot_(robot), clearances_(robot, clearance)
{
    for (const Robot::Impl::PartPair& pair : robot.pairs) grids_.push_back(grid_of(pair));
}

JointCells::Grid JointCells::grid_of(const Robot::Impl::PartPair& pair) const
{
    Grid grid;
    std::vector<Kinematics::Acting> acting;
    if (!robot_.tree.numbers_between(robot_.parts[pair.a].link, robot_.parts[pair.b].link, acting)) return grid;
    if (acting.size() > most_axes) return grid;
    for (const auto& [number, turns] : acting) {
        const std::vector<RobotJoint>& joints = robot_.description.joints;
        std::uint32_t owner = 0;
        while (robot_.tree.first_number(owner) != static_cast<int>(number)) ++owner;
        const double low = turns ? 0 : joints[owner].lower, high = turns ? 2 * std::numbers::pi : joints[owner].upper;
        if (!(high > low && std::max(std::abs(low), std::abs(high)) < largest_number)) return Grid();
        grid.axes.push_back({number, low, (high - low) / steps, turns});
    }
    if (grid.axes.empty()) return grid;
    grid.cells = std::make_unique<Cells[]>(2);
    grid.cells[fine].per_step = most_fine[grid.axes.size() - 1];
    return grid;
}

JointCells::Edge JointCells::edge_of(std::uint32_t pair, const double* from, const double* to) const
{
    Edge edge{pair, 0, {}, {}};
    std::size_t i = 0;
    for (const Axis& axis : grids_[pair].axes) {
        edge.from[i] = (from[axis.number] - axis.low) / axis.step;
        edge.way[i] = (to[axis.number] - from[axis.number]) / axis.step;
        edge.width = std::max(edge.width, std::abs(edge.way[i++]));
        if (!(std::max(std::abs(from[axis.number]), std::abs(to[axis.number])) < largest_number))
            edge.width = std::numeric_limits<double>::infinity(); // no cell is wide enough
    }
    return edge;
}

bool JointCells::is_clear(const World& world, const Edge& edge, Level level, double share, Scratch& scratch)
{
    Grid& grid = grids_[edge.pair];
    Cells& cells = grid.cells[level];
    const std::int64_t side = steps * cells.per_step;
    const auto per_step = static_cast<double>(cells.per_step);
    Cell cell{};
    std::size_t index = 0;
    for (std::size_t i = 0; i < grid.axes.size(); ++i) {
        const double at = edge.from[i] + share * edge.way[i];
        if (grid.axes[i].is_periodic)
            cell[i] = static_cast<std::int64_t>((at + turns_above) * per_step + 0.5) & (side - 1);
        else if (at >= 0 && at <= steps)
            cell[i] = static_cast<std::int64_t>(at * per_step + 0.5);
        else
            return false;
        index = index * static_cast<std::size_t>(side + 1) + static_cast<std::size_t>(cell[i]);
    }
    call_once(cells.made, [&] {
        cells.count = 1;
        for (std::size_t i = 0; i < grid.axes.size(); ++i) cells.count *= static_cast<std::size_t>(side + 1);
        cells.words = std::make_unique<std::atomic<std::uint64_t>[]>(cells.count / 32 + 1);
    });
    std::atomic<std::uint64_t>& word = cells.words[index / 32];
    const auto shift = 2 * (index % 32);
    std::uint64_t state = word.load(std::memory_order_relaxed) >> shift & 3;
    if (state == unknown) {
        state = are_apart(world, edge.pair, per_step, cell, scratch) ? clear : open;
        word.fetch_or(state << shift, std::memory_order_relaxed);
    }
    return state == clear;
}

/// True if the pair is certainly apart while each number is at most one cell width from the cell's middle. The pair is
/// then apart in every window that is no wider than a cell and whose middle is in the cell.
bool JointCells::are_apart(const World& world, std::uint32_t p, double per_step, const Cell& cell,
                           Scratch& scratch) const
{
    const Robot::Impl::PartPair& pair = robot_.pairs[p];
    const Robot::Impl::Part &a = robot_.parts[pair.a], &b = robot_.parts[pair.b];
    scratch.middle = robot_.neutral, scratch.from = robot_.neutral, scratch.to = robot_.neutral;
    for (std::size_t i = 0; const Axis& axis : grids_[p].axes) {
        const double width = axis.step / per_step, middle = axis.low + double(cell[i++]) * width;
        scratch.middle[axis.number] = middle;
        scratch.from[axis.number] = middle - width * (1 + 1e-9), scratch.to[axis.number] = middle + width * (1 + 1e-9);
    }
    scratch.links.resize(robot_.description.links.size(), Eigen::Isometry3d::Identity());
    const Eigen::Isometry3d* const links = scratch.links.data();
    robot_.tree.link_poses(scratch.middle.data(), Eigen::Isometry3d::Identity(), scratch.links.data());
    double moved = 0, size = 0;
    for (const Robot::Impl::Part* part : {&a, &b}) {
        const CoverSphere& ball = part->cover.whole;
        moved +=
            robot_.tree.travel(scratch.from.data(), scratch.to.data(), 0.5, links, ball, part->link, pair.seen_from)
                .moved;
        size += ball.centre.norm() + ball.radius;
    }
    const Eigen::Vector3d apart = links[a.link] * a.cover.whole.centre - links[b.link] * b.cover.whole.centre;
    size += apart.norm();
    const double slack = 1e-12 * (links[a.link].translation().norm() + links[b.link].translation().norm());
    const double reach = moved * robot_.stretch() + robot_.rounding() * size + slack;
    const double balls = (a.cover.whole.radius + b.cover.whole.radius) * robot_.stretch();
    const double reach_and_padding = reach + clearances_.of_links(a.link, b.link) - clearances_.of_world();
    if (apart.norm() > balls + reach_and_padding + clearances_.of_world()) return true;
    const PairOfModels models{{a.model, robot_.pose_of(a, links)}, {b.model, robot_.pose_of(b, links)}};
    std::uint8_t near = 1;
    WorldAccess::near(world, {&models, 1}, {&reach_and_padding, 1}, {&near, 1});
    return near == 0;
}

std::shared_ptr<JointCells> Robot::Impl::joint_cells(double clearance) const
{
    const std::lock_guard lock(cells_mutex);
    if (!cells || cells->clearance() != clearance) cells = std::make_shared<JointCells>(*this, clearance);
    return cells;
}

} // namespace oncollide
