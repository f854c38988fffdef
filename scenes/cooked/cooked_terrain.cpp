#include <oncollide/scenes/cooked/cooked_terrain.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/cooked/cooked_writer.hpp>
#include <oncollide/scenes/model/terrain/terrain_access.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace oncollide {

namespace {

constexpr std::uint32_t side = TerrainChunks::side, tile = Terrain::tile, of_tile = tile * tile;

std::uint32_t parts_of(std::uint32_t length, std::uint32_t part)
{
    return (length + part - 1) / part;
}

} // namespace

CookedTerrain::Extent CookedTerrain::extent(const Terrain& terrain, std::size_t chunk)
{
    const std::uint32_t across = parts_of(terrain.columns(), side);
    const auto x = static_cast<std::uint32_t>(chunk % across), y = static_cast<std::uint32_t>(chunk / across);
    Extent extent{};
    extent.columns = std::min(side, terrain.columns() - x * side),
    extent.rows = std::min(side, terrain.rows() - y * side);
    extent.tiles_x = parts_of(extent.columns, tile), extent.tiles = extent.tiles_x * parts_of(extent.rows, tile);
    return extent;
}

/// Bytes of the heights in tiles, and of the diagonals if each cell has its own.
std::uint64_t CookedTerrain::bytes_of(const Terrain& terrain, std::size_t chunk)
{
    const std::uint64_t tiles = extent(terrain, chunk).tiles, each = std::uint64_t(terrain.bytes_per_height());
    return tiles * (each * of_tile + (each < 4 ? sizeof(TerrainTile) : 0)) + (terrain.mixed_diagonals() ? side * 8 : 0);
}

std::size_t CookedTerrain::chunk_bytes(std::size_t chunk) const
{
    return table_[chunk].bytes;
}

void CookedTerrain::refuse_chunk(std::size_t chunk, const std::string& why) const
{
    file_.refuse_chunk(chunk, table_.size(), why);
}

CookedTerrainRecord CookedTerrain::record_of(const Terrain& t)
{
    CookedTerrainRecord record{};
    record.columns = t.columns_, record.rows = t.rows_;
    std::copy_n(t.spacing_.data(), 2, record.spacing), std::copy_n(t.origin_.data(), 3, record.origin);
    record.least[0] = t.least_.column, record.least[1] = t.least_.row;
    record.greatest[0] = t.greatest_.column, record.greatest[1] = t.greatest_.row;
    record.low = t.low_, record.high = t.high_, record.error = t.error_, record.unit = t.unit_;
    record.cells = t.cells_, record.holes = t.holes_;
    record.diagonal = t.mixed_ ? 2 : std::uint32_t(t.diagonal_);
    return record;
}

void CookedTerrain::add_chunk(const Terrain& terrain, std::size_t chunk, CookedBytes& to)
{
    const Extent part = extent(terrain, chunk);
    const std::uint32_t across = parts_of(terrain.columns_, side);
    const auto x = static_cast<std::uint32_t>(chunk % across) * side,
               y = static_cast<std::uint32_t>(chunk / across) * side;
    const auto each_row = [&](auto visit) { // calls visit(number of the row's first tile)
        for (std::uint32_t row = 0; row < part.tiles / part.tiles_x; ++row)
            visit(std::size_t(y / tile + row) * terrain.tiles_x_ + x / tile);
    };
    if (terrain.bytes_per_height() < 4)
        each_row([&](std::size_t first) { to.add(std::span(&terrain.heights_->tiles[first], part.tiles_x)); });
    std::visit(
        [&](const auto& samples) {
            each_row([&](std::size_t first) { to.add(std::span(&samples[first * of_tile], part.tiles_x * of_tile)); });
        },
        terrain.heights_->samples);
    if (!terrain.mixed_) return;
    for (std::uint32_t j = 0; j < side; ++j) {
        std::uint64_t bits = 0;
        for (std::uint32_t i = 0; i < side; ++i)
            if (x + i < terrain.cells_x() && y + j < terrain.cells_y())
                bits |= std::uint64_t(TerrainAccess::diagonal(terrain, x + i, y + j) == CellDiagonal::falling) << i;
        to.add(bits);
    }
}

CookedTerrain::CookedTerrain(const std::filesystem::path& path) : file_(path)
{
    const CookedFile::Opened opened = file_.open(CookedKind::terrain);
    auto record = opened.record();
    take_record(take<CookedTerrainRecord>(record), opened.header);
    handle_ = opened.handle, checksum_ = opened.header.header_checksum, table_ = opened.table(),
    parts_ = opened.parts();
    if (parts_) file_.check_parts(*parts_, outline_->bounds());
    const Terrain& t = *outline_;
    across_ = parts_of(t.columns(), side), blocks_across_ = parts_of(t.cells_x(), side);
    const std::uint64_t blocks = std::uint64_t(blocks_across_) * parts_of(t.cells_y(), side);
    if (opened.header.nodes != blocks || table_.size() != std::uint64_t(across_) * parts_of(t.rows(), side))
        file_.refuse("has impossible counts");
    file_.check_table(opened, table_, [&](const CookedChunkEntry& entry, std::size_t chunk) {
        if (entry.triangles || entry.vertices) file_.refuse_entry(chunk);
        return bytes_of(t, chunk);
    });
    ranges_.resize(blocks);
    auto nodes = opened.nodes();
    take(nodes, std::span(ranges_));
    // A block without cells has the range from infinity to -infinity. Other ranges are compared with the heights when
    // these are read.
    const double half = t.bounds().half_extent().z() * (1 + 0x1p-20);
    for (const CookedRange& range : ranges_) {
        const bool nothing = std::isinf(range.low) && range.low > 0 && range.high == -range.low && t.holes();
        if (!nothing && !(range.low >= -half && range.low <= range.high && range.high <= half))
            file_.refuse("has a block that is not within its bounds");
    }
}

/// Makes the same checks as make_terrain().
void CookedTerrain::take_record(const CookedTerrainRecord& record, const CookedHeader& header)
{
    constexpr double farthest = 1e15;
    Terrain t;
    t.columns_ = record.columns, t.rows_ = record.rows;
    if (t.columns_ < 2 || t.rows_ < 2 || std::uint64_t(t.columns_ - 1) * (t.rows_ - 1) > Terrain::most_cells ||
        record.diagonal > 2 || record.holes > 1 || record.cells == 0)
        file_.refuse("has an impossible grid");
    const std::uint64_t all = std::uint64_t(t.cells_x()) * t.cells_y();
    if (record.cells > all || record.holes != (record.cells < all)) file_.refuse("has an impossible grid");
    t.spacing_ = {record.spacing[0], record.spacing[1]};
    t.origin_ = {record.origin[0], record.origin[1], record.origin[2]};
    const std::uint32_t last[2] = {t.cells_x(), t.cells_y()};
    for (int i = 0; i < 2; ++i) {
        const double from = t.origin_[i], to = from + t.spacing_[i] * last[i];
        const double far = std::max(std::abs(from), std::abs(to));
        if (!(t.spacing_[i] > 0 && far <= farthest && t.spacing_[i] >= 0x1p-30 * far) ||
            record.least[i] >= record.greatest[i] || record.greatest[i] > last[i])
            file_.refuse("has an impossible grid");
    }
    if (!(std::abs(t.origin_.z()) <= farthest && record.low >= -farthest && record.low <= record.high &&
          record.high <= farthest && record.error >= 0 && record.error <= farthest && record.unit >= 0 &&
          record.unit <= farthest))
        file_.refuse("has heights that are not finite or too far");
    t.least_ = {record.least[0], record.least[1]}, t.greatest_ = {record.greatest[0], record.greatest[1]};
    t.low_ = record.low, t.high_ = record.high, t.error_ = record.error, t.unit_ = record.unit;
    t.cells_ = record.cells, t.holes_ = record.holes;
    t.mixed_ = record.diagonal == 2, t.diagonal_ = record.diagonal == 1 ? CellDiagonal::falling : CellDiagonal::rising;
    t.bytes_ = static_cast<int>(header.coordinate_bytes);
    if (t.bytes_ != 1 && t.bytes_ != 2 && t.bytes_ != 4 && t.bytes_ != 8)
        file_.refuse(fmt::format("has heights of {} bytes; must be 1, 2, 4 or 8", header.coordinate_bytes));
    t.find_bounds();
    if (std::memcmp(header.low, t.bounds_.min.data(), sizeof header.low) != 0 ||
        std::memcmp(header.high, t.bounds_.max.data(), sizeof header.high) != 0)
        file_.refuse("has bounds that do not match its grid");
    outline_ = std::move(t);
}

std::unique_ptr<TerrainChunk> CookedTerrain::read(std::size_t number) const
{
    const std::vector<std::byte> bytes = file_.read(*handle_, table_[number], number, table_.size());
    std::span<const std::byte> rest(bytes);
    const Terrain& t = *outline_;
    const Extent part = extent(t, number);
    ONCOLLIDE_ASSERT(number < table_.size() && part.tiles > 0);
    auto chunk = std::make_unique<TerrainChunk>();
    chunk->tiles_x = part.tiles_x;
    const auto each = static_cast<std::size_t>(t.bytes_per_height());
    if (each < 4) {
        chunk->tiles.resize(part.tiles);
        take(rest, std::span(chunk->tiles));
    }
    chunk->samples.resize(part.tiles * of_tile * each);
    take(rest, std::span(chunk->samples));
    if (t.mixed_) {
        chunk->falling.resize(side);
        take(rest, std::span(chunk->falling));
    }
    if (std::ranges::any_of(chunk->tiles, [](const TerrainTile& of) { return of.shift > 31; }))
        refuse_chunk(number, "a tile is impossible");
    if (t.holes_ && each < 4) return chunk; // any value is a height: heights of cells are compared with the top
    constexpr double farthest = 1e15;
    const double off = t.error_ * (1 + 0x1p-20); // the bounds were computed before the heights were rounded for storing
    const double low = t.holes_ ? -farthest : t.low_ - off, high = t.holes_ ? farthest : t.high_ + off;
    for (std::uint32_t row = 0; row < part.rows; ++row)
        for (std::uint32_t column = 0; column < part.columns; column += tile) {
            double heights[tile];
            const std::uint32_t count = std::min(tile, part.columns - column);
            TerrainChunks::decode(t, *chunk, row / tile * part.tiles_x + column / tile, row % tile * tile, count,
                                  heights);
            bool within = true;
            for (std::uint32_t i = 0; i < count; ++i)
                within &= (heights[i] >= low && heights[i] <= high) || (t.holes_ && std::isnan(heights[i]));
            if (!within) refuse_chunk(number, "a height is not within the bounds");
        }
    return chunk;
}

CookedTerrainChunks::CookedTerrainChunks(std::shared_ptr<const CookedTerrain> cooked, ChunkBudget* budget)
    : CookedTerrainChunks(cooked, budget ? nullptr : std::make_unique<ChunkBudget>(0), budget)
{
}

CookedTerrainChunks::CookedTerrainChunks(std::shared_ptr<const CookedTerrain> cooked, std::unique_ptr<ChunkBudget> own,
                                         ChunkBudget* budget)
    : TerrainChunks(cooked->outline(), own ? *own : *budget), cooked_(std::move(cooked)), own_(std::move(own)),
      budget_(own_ ? *own_ : *budget)
{
    ONCOLLIDE_ASSERT(chunks_.size() == cooked_->chunks());
}

CookedTerrainChunks::~CookedTerrainChunks()
{
    for (std::size_t chunk = 0; chunk < chunks_.size(); ++chunk) drop(chunk);
}

Terrain CookedTerrainChunks::terrain(std::shared_ptr<const CookedTerrain> cooked, ChunkBudget* budget)
{
    const Terrain& outline = cooked->outline();
    return TerrainAccess::in_chunks(outline, std::make_shared<CookedTerrainChunks>(std::move(cooked), budget));
}

const TerrainChunk& CookedTerrainChunks::need(std::size_t chunk) const
{
    ONCOLLIDE_ASSERT(chunk < chunks_.size());
    const std::lock_guard lock(reading_);
    if (const TerrainChunk* there = chunks_[chunk].load(std::memory_order_acquire)) return *there;
    const std::size_t bytes = sizeof(TerrainChunk) + cooked_->chunk_bytes(chunk);
    budget_.take(bytes, cooked_->file().name());
    try {
        chunks_[chunk].store(cooked_->read(chunk).release(), std::memory_order_release);
    } catch (...) {
        budget_.give(bytes);
        throw;
    }
    held_ += bytes;
    needed_[chunk].store(budget_.now(), std::memory_order_relaxed);
    return *chunks_[chunk].load(std::memory_order_relaxed);
}

void CookedTerrainChunks::need_all() const
{
    for (std::size_t chunk = 0; chunk < chunks_.size(); ++chunk) at(chunk);
}

void CookedTerrainChunks::drop(std::size_t chunk)
{
    ONCOLLIDE_ASSERT(chunk < chunks_.size());
    const std::unique_ptr<const TerrainChunk> gone(chunks_[chunk].exchange(nullptr));
    if (!gone) return;
    const std::size_t bytes = sizeof(TerrainChunk) + cooked_->chunk_bytes(chunk);
    budget_.give(bytes), held_ -= bytes;
}

CookedTerrainChunks* cooked_chunks(const Terrain& terrain)
{
    return static_cast<CookedTerrainChunks*>(TerrainAccess::chunks(terrain)); // there are no other chunks
}

} // namespace oncollide
