#include <oncollide/samples/generators.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

namespace {

constexpr double room_side = 4, room_height = 2.75; // metres

/// Fills boxes of cells. Coordinates are in cells; the building's floor is centred on the origin, at z = 0.
class Builder {
public:
    explicit Builder(int offset) : offset_(offset, offset, 0) {}

    void fill(int x0, int y0, int z0, int x1, int y1, int z1) { set({x0, y0, z0}, {x1, y1, z1}, CellState::occupied); }
    void clear(int x0, int y0, int z0, int x1, int y1, int z1) { set({x0, y0, z0}, {x1, y1, z1}, CellState::free); }
    CellTree finish() { return std::move(cells_); }

private:
    void set(const Eigen::Vector3i& low, const Eigen::Vector3i& high, CellState state)
    {
        cells_.set({low - offset_, high - offset_}, state);
    }

    CellTree cells_;
    Eigen::Vector3i offset_;
};

/// Adds a piece of furniture: a box on the floor, in the room whose first cell is (x, y).
void furnish(Builder& builder, int x, int y, int room, int height, std::uint64_t seed, std::uint64_t index)
{
    const int free = room - 2;
    const auto pick = [&](std::uint64_t k, int low, int high) { // low to high, both included
        return low + static_cast<int>(u01(seed, index, k) * (high - low + 1));
    };
    const int wide = pick(0, 1, std::max(1, free / 3)), deep = pick(1, 1, std::max(1, free / 3));
    const int tall = pick(2, 1, std::max(1, 2 * height / 3));
    const int left = x + 1 + pick(3, 0, std::max(0, free - wide)), front = y + 1 + pick(4, 0, std::max(0, free - deep));
    builder.fill(left, front, 1, left + wide, front + deep, 1 + tall);
}

} // namespace

OccupancyMap make_building_map(int rooms, double resolution, std::uint64_t seed)
{
    if (rooms < 1 || rooms > 100)
        throw Error(ErrorKind::usage, fmt::format("building: {} rooms per side; it must be from 1 to 100", rooms));
    if (!(resolution > 0) || !std::isfinite(resolution) || resolution > 1 || rooms * room_side / resolution > 2000)
        throw Error(ErrorKind::usage,
                    fmt::format("building: the resolution is {} m; with {} rooms per side it must be from {} to 1",
                                resolution, rooms, rooms * room_side / 2000));
    const int room = static_cast<int>(std::lround(room_side / resolution));
    const int height = std::max(2, static_cast<int>(std::lround(room_height / resolution)));
    const int side = rooms * room + 1, door = std::max(1, room / 4), lintel = std::max(2, 3 * height / 4);

    Builder builder(side / 2);
    builder.fill(0, 0, 0, side, side, 1);
    for (int wall = 0; wall <= rooms; ++wall) {
        builder.fill(wall * room, 0, 1, wall * room + 1, side, 1 + height);
        builder.fill(0, wall * room, 1, side, wall * room + 1, 1 + height);
    }
    for (int i = 0; i < rooms; ++i)
        for (int j = 0; j < rooms; ++j) {
            const int x = i * room, y = j * room, index = i * rooms + j;
            const int middle = std::max(1, (room - door) / 2);
            if (i > 0) builder.clear(x, y + middle, 1, x + 1, y + middle + door, lintel);
            if (j > 0) builder.clear(x + middle, y, 1, x + middle + door, y + 1, lintel);
            const int pieces = 2 + static_cast<int>(3 * u01(seed, static_cast<std::uint64_t>(index), 1000));
            for (int piece = 0; piece < pieces; ++piece)
                furnish(builder, x, y, room, height, seed + 1, static_cast<std::uint64_t>(index) * 8 + piece);
        }
    return MapAccess::make("building", builder.finish(), resolution);
}

} // namespace oncollide
