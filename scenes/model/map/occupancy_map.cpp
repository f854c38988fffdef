#include <oncollide/scenes/model/occupancy_map.hpp>

#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>
#include <oncollide/scenes/model/map/map_change.hpp>

namespace oncollide {

void check_resolution(const std::string& name, double resolution)
{
    constexpr double least = 1e-6, most = 1e6;
    if (!(resolution >= least && resolution <= most))
        throw Error(ErrorKind::bad_data,
                    fmt::format("{}: the resolution is {}; it must be from {} to {} m", name, resolution, least, most));
}

OccupancyMap::OccupancyMap(std::unique_ptr<MapData> data, double resolution)
    : resolution_(resolution), data_(std::move(data))
{
    MapAccess::set_bounds(*this, data_->bounds);
}

OccupancyMap::OccupancyMap(const OccupancyMap& other)
    : resolution_(other.resolution_), bounds_(other.bounds_), data_(std::make_unique<MapData>(*other.data_))
{
}

OccupancyMap& OccupancyMap::operator=(const OccupancyMap& other)
{
    return *this = OccupancyMap(other);
}

OccupancyMap::OccupancyMap(OccupancyMap&&) noexcept = default;
OccupancyMap& OccupancyMap::operator=(OccupancyMap&&) noexcept = default;
OccupancyMap::~OccupancyMap() = default;

OccupancyMap MapAccess::make(const std::string& name, CellTree cells, double resolution)
{
    check_resolution(name, resolution);
    const CellBox bounds = cells.bounds();
    OccupancyMap map = make(std::move(cells), resolution, bounds);
    if (empty(map)) throw Error(ErrorKind::bad_data, name + ": no cell of the map is occupied");
    return map;
}

OccupancyMap MapAccess::make(CellTree cells, double resolution, const CellBox& bounds)
{
    return {std::make_unique<MapData>(MapData{std::move(cells), bounds}), resolution};
}

OccupancyMap make_occupancy_map(const std::string& name, double resolution, std::span<const MapCell> occupied,
                                std::span<const MapCell> free, bool unknown_is_occupied)
{
    CellTree cells(unknown_is_occupied);
    const auto within = [](std::int32_t at, std::int32_t side) {
        return at >= CellTree::lowest && at <= CellTree::lowest + CellTree::side - side;
    };
    const auto set = [&](std::span<const MapCell> cubes, CellState state) {
        for (const MapCell& cube : cubes) {
            const auto& [x, y, z, side] = cube;
            if (side < 1 || side > CellTree::side || !within(x, side) || !within(y, side) || !within(z, side))
                throw Error(ErrorKind::usage,
                            fmt::format("{}: the cube with side {} at ({}, {}, {}) is not within the grid", name, side,
                                        x, y, z));
            cells.set(CellBox(cube), state);
        }
    };
    set(occupied, CellState::occupied), set(free, CellState::free);
    return MapAccess::make(name, std::move(cells), resolution);
}

void MapAccess::set_bounds(OccupancyMap& map, const CellBox& cells)
{
    ONCOLLIDE_ASSERT(map.resolution_ > 0);
    map.data_->bounds = cells;
    map.bounds_ = {cells.low.cast<double>() * map.resolution_, cells.high.cast<double>() * map.resolution_};
}

bool MapAccess::empty(const OccupancyMap& map)
{
    return each_cell(map, map.bounds_, [](const MapCell&) { return false; });
}

CellBox MapAccess::cells_touching(const OccupancyMap& map, const Aabb& box)
{
    const auto cell = [](const Eigen::Array3d& at) -> Eigen::Vector3i {
        return at.max(-4.0 * CellTree::side).min(4.0 * CellTree::side).cast<int>();
    };
    const double scale = 1 / map.resolution_;
    return {cell((box.min.array() * scale - 1e-9).floor()), cell((box.max.array() * scale + 1e-9).ceil())};
}

Aabb OccupancyMap::box(const MapCell& cube) const
{
    return MapAccess::box(*this, cube);
}

bool OccupancyMap::each_cell(const Aabb& around, const std::function<bool(const MapCell&)>& visit) const
{
    return MapAccess::each_cell(*this, around, [&](const MapCell& cube) { return visit(cube); });
}

void OccupancyMap::each_box(const std::function<void(const Aabb&)>& visit) const
{
    MapAccess::each_cell(*this, bounds_, [&](const MapCell& cube) { return visit(box(cube)), true; });
}

std::size_t OccupancyMap::count() const
{
    std::size_t boxes = 0;
    MapAccess::each_cell(*this, bounds_, [&](const MapCell&) { return ++boxes, true; });
    return boxes;
}

void OccupancyMap::keep(std::shared_ptr<const octomap::OcTree> tree)
{
    data_->given = std::move(tree);
}

std::size_t OccupancyMap::bytes() const
{
    return data_->cells.bytes();
}

CellBox cell_at(const OccupancyMap& map, const Eigen::Vector3d& point)
{
    const Eigen::Array3d at = (point.array() / map.resolution()).floor();
    if (!((at >= CellTree::lowest).all() && (at < CellTree::lowest + CellTree::side).all()))
        throw Error(ErrorKind::usage,
                    fmt::format("map: the point ({}, {}, {}) is beyond the map's grid, which reaches {} m from its "
                                "origin",
                                point.x(), point.y(), point.z(), -CellTree::lowest * map.resolution()));
    const Eigen::Vector3i cell = at.cast<int>();
    return {cell, cell.array() + 1};
}

namespace {

/// The cells whose centres are in the box.
CellBox cells_in(const OccupancyMap& map, const Aabb& box)
{
    if (box.min.hasNaN() || box.max.hasNaN())
        throw Error(ErrorKind::usage, "map: the box has a coordinate that is not a number");
    const auto cell = [](const Eigen::Array3d& at) -> Eigen::Vector3i {
        return at.max(CellTree::lowest).min(CellTree::lowest + CellTree::side).cast<int>();
    };
    return {cell((box.min.array() / map.resolution() - 0.5).ceil()),
            cell((box.max.array() / map.resolution() - 0.5).floor() + 1)};
}

} // namespace

MapChange::MapChange(OccupancyMap& map, bool by_scan)
    : map_(map), data_(MapAccess::data(map)), bounds_before_(data_.bounds), bounds_(data_.bounds),
      known_before_(std::ssize(data_.since_scan)), octree_is_to_know_(!by_scan && (data_.given || data_.scanned))
{
}

MapChange::~MapChange()
{
    if (done_) return;
    for (auto old = before_.rbegin(); old != before_.rend(); ++old) data_.cells.set(CellBox(old->first), old->second);
    MapAccess::set_bounds(map_, bounds_before_);
    data_.since_scan.erase(data_.since_scan.begin() + known_before_, data_.since_scan.end());
}

void MapChange::set(const CellBox& box, CellState state)
{
    if (box.empty()) return;
    data_.cells.set(box, state, &before_);
    if (state == CellState::occupied || (state == CellState::free && data_.cells.unknown_is_solid()))
        bounds_ = {bounds_.low.cwiseMin(box.low), bounds_.high.cwiseMax(box.high)};
    else if ((box.low.array() <= bounds_.low.array()).any() || (box.high.array() >= bounds_.high.array()).any())
        search_ = true;
    if (octree_is_to_know_) data_.since_scan.push_back({box, state});
}

void MapChange::commit()
{
    MapAccess::set_bounds(map_, search_ ? data_.cells.bounds() : bounds_);
    if (MapAccess::empty(map_))
        throw Error(ErrorKind::usage, "map: no cell would be left occupied; remove the bodies of the map instead");
    done_ = true;
}

void OccupancyMap::set(std::span<const Eigen::Vector3d> points, CellState state)
{
    for (const Eigen::Vector3d& point : points) cell_at(*this, point);
    MapChange change(*this);
    for (const Eigen::Vector3d& point : points) change.set(cell_at(*this, point), state);
    change.commit();
}

void OccupancyMap::set(const Aabb& box, CellState state)
{
    const CellBox cells = cells_in(*this, box);
    MapChange change(*this);
    change.set(cells, state);
    change.commit();
}

void OccupancyMap::replace(const Aabb& box, const OccupancyMap& by)
{
    if (by.resolution_ != resolution_)
        throw Error(ErrorKind::usage, fmt::format("map: replaced by a map with a resolution of {} m; it must be {}",
                                                  by.resolution_, resolution_));
    const CellBox cells = cells_in(*this, box);
    MapChange change(*this);
    change.set(cells, CellState::unknown);
    by.data_->cells.each_leaf([&](const MapCell& cube, CellState state) {
        const CellBox leaf(cube);
        change.set({leaf.low.cwiseMax(cells.low), leaf.high.cwiseMin(cells.high)}, state);
    });
    change.commit();
}

} // namespace oncollide
