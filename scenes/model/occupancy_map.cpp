#include <oncollide/scenes/model/occupancy_map.hpp>

#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/map_box.hpp>
#include <oncollide/scenes/model/map_change.hpp>

namespace oncollide {

void check_resolution(const std::string& name, double resolution)
{
    constexpr double least = 1e-6, most = 1e6;
    if (!(resolution >= least && resolution <= most))
        throw Error(ErrorKind::bad_data,
                    fmt::format("{}: the resolution is {}; it must be from {} to {} m", name, resolution, least, most));
}

OccupancyMap::OccupancyMap(const std::string& name, CellTree cells, double resolution)
    : cells_(std::move(cells)), resolution_(resolution), cell_bounds_(cells_.bounds())
{
    check_resolution(name, resolution);
    set_bounds(cell_bounds_);
    if (empty()) throw Error(ErrorKind::bad_data, name + ": no cell of the map is occupied");
}

Aabb OccupancyMap::box(const MapCell& cube) const
{
    return box_in(*this, cube);
}

CellBox OccupancyMap::cells_touching(const Aabb& box) const
{
    const auto cell = [](const Eigen::Array3d& at) -> Eigen::Vector3i {
        return at.max(-4.0 * CellTree::side).min(4.0 * CellTree::side).cast<int>();
    };
    const double scale = 1 / resolution_;
    return {cell((box.min.array() * scale - 1e-9).floor()), cell((box.max.array() * scale + 1e-9).ceil())};
}

void OccupancyMap::set_bounds(const CellBox& cells)
{
    cell_bounds_ = cells;
    bounds_ = {cells.low.cast<double>() * resolution_, cells.high.cast<double>() * resolution_};
}

bool OccupancyMap::empty() const
{
    return each_cell(bounds_, [](const MapCell&) { return false; });
}

std::size_t OccupancyMap::count() const
{
    std::size_t boxes = 0;
    each_cell(bounds_, [&](const MapCell&) { return ++boxes, true; });
    return boxes;
}

CellBox OccupancyMap::cell_at(const Eigen::Vector3d& point) const
{
    const Eigen::Array3d at = (point.array() / resolution_).floor();
    if (!((at >= CellTree::lowest).all() && (at < CellTree::lowest + CellTree::side).all()))
        throw Error(ErrorKind::usage,
                    fmt::format("map: the point ({}, {}, {}) is beyond the map's grid, which reaches {} m from its "
                                "origin",
                                point.x(), point.y(), point.z(), -CellTree::lowest * resolution_));
    const Eigen::Vector3i cell = at.cast<int>();
    return {cell, cell.array() + 1};
}

CellBox OccupancyMap::cells_in(const Aabb& box) const
{
    if (box.min.hasNaN() || box.max.hasNaN())
        throw Error(ErrorKind::usage, "map: the box has a coordinate that is not a number");
    const auto cell = [](const Eigen::Array3d& at) -> Eigen::Vector3i {
        return at.max(CellTree::lowest).min(CellTree::lowest + CellTree::side).cast<int>();
    };
    return {cell((box.min.array() / resolution_ - 0.5).ceil()),
            cell((box.max.array() / resolution_ - 0.5).floor() + 1)};
}

MapChange::~MapChange()
{
    if (done_) return;
    for (auto old = before_.rbegin(); old != before_.rend(); ++old) map_.cells_.set(CellBox(old->first), old->second);
    map_.set_bounds(bounds_before_);
    map_.since_scan_.erase(map_.since_scan_.begin() + known_before_, map_.since_scan_.end());
}

void MapChange::set(const CellBox& box, CellState state)
{
    if (box.empty()) return;
    map_.cells_.set(box, state, &before_);
    if (state == CellState::occupied || (state == CellState::free && map_.cells_.unknown_is_solid()))
        bounds_ = {bounds_.low.cwiseMin(box.low), bounds_.high.cwiseMax(box.high)};
    else if ((box.low.array() <= bounds_.low.array()).any() || (box.high.array() >= bounds_.high.array()).any())
        search_ = true;
    if (octree_is_to_know_) map_.since_scan_.push_back({box, state});
}

void MapChange::commit()
{
    map_.set_bounds(search_ ? map_.cells_.bounds() : bounds_);
    if (map_.empty())
        throw Error(ErrorKind::usage, "map: no cell would be left occupied; remove the bodies of the map instead");
    done_ = true;
}

void OccupancyMap::set(std::span<const Eigen::Vector3d> points, CellState state)
{
    for (const Eigen::Vector3d& point : points) cell_at(point);
    MapChange change(*this);
    for (const Eigen::Vector3d& point : points) change.set(cell_at(point), state);
    change.commit();
}

void OccupancyMap::set(const Aabb& box, CellState state)
{
    const CellBox cells = cells_in(box);
    MapChange change(*this);
    change.set(cells, state);
    change.commit();
}

void OccupancyMap::replace(const Aabb& box, const OccupancyMap& by)
{
    if (by.resolution_ != resolution_)
        throw Error(ErrorKind::usage, fmt::format("map: replaced by a map with a resolution of {} m; it must be {}",
                                                  by.resolution_, resolution_));
    const CellBox cells = cells_in(box);
    MapChange change(*this);
    change.set(cells, CellState::unknown);
    by.cells_.each_leaf([&](const MapCell& cube, CellState state) {
        const CellBox leaf(cube);
        change.set({leaf.low.cwiseMax(cells.low), leaf.high.cwiseMin(cells.high)}, state);
    });
    change.commit();
}

} // namespace oncollide
