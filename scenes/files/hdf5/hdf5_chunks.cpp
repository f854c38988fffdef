#include <oncollide/scenes/files/hdf5/hdf5_chunks.hpp>

#include <algorithm>
#include <utility>

#include <oncollide/scenes/files/hdf5/hdf5_btree.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_filters.hpp>

namespace oncollide {

namespace {

using LayoutKind = Hdf5Layout::Kind;

std::uint64_t rounded_up(std::uint64_t extent, std::uint64_t edge)
{
    return extent / edge + (extent % edge != 0);
}

struct Reader {
    Hdf5Walk& walk;
    const Hdf5Layout& layout;
    const Hdf5Space& space;
    const Hdf5Grid& grid;
    std::uint64_t chunk_bytes;
    std::vector<Hdf5Chunk> chunks{};
    std::vector<std::uint64_t> at{}; ///< position of a chunk

    void add(std::uint64_t address, std::uint64_t bytes, std::uint32_t skipped)
    {
        if (address == hdf5_nowhere || !grid.contains(at))
            return; // chunks outside the dataset may remain when a
                    // dataset shrinks
        chunks.push_back({grid.number(at), address, bytes, skipped});
    }

    void read_old_btree()
    {
        const unsigned key_bytes = 8 + 8 * (static_cast<unsigned>(grid.dimensions()) + 1);
        walk_old_btree(walk, layout.address, 1, key_bytes, [&](Hdf5Cursor key, std::uint64_t address) {
            const std::uint64_t bytes = key.u32();
            const std::uint32_t skipped = key.u32();
            for (std::size_t d = 0; d < at.size(); ++d) {
                at[d] = key.number(8);
                if (at[d] % layout.edges[d]) key.damaged("a chunk is between the places of chunks");
                at[d] /= layout.edges[d];
            }
            add(address, bytes, skipped);
        });
    }

    void read_btree()
    {
        constexpr unsigned plain = 10, filtered = 11;
        walk_btree(walk, layout.address, plain, filtered, [&](Hdf5Cursor record) {
            const std::uint64_t address = record.address(), coordinates = 8 * grid.dimensions();
            std::uint64_t bytes = chunk_bytes;
            std::uint32_t skipped = 0;
            if (record.left() > coordinates) {
                if (record.left() < coordinates + 5) record.damaged("a chunk's record is too short");
                bytes =
                    record.number(static_cast<unsigned>(std::min<std::uint64_t>(8, record.left() - coordinates - 4)));
                skipped = record.u32();
            }
            for (std::uint64_t& place : at) place = record.number(8);
            add(address, bytes, skipped);
        });
    }

    /// The elements of an array count chunks up to the largest possible shape. An unlimited dimension comes first.
    void add_element(std::uint64_t number, Hdf5Cursor element, std::size_t first)
    {
        const std::uint64_t address = element.address();
        if (address == hdf5_nowhere) return;
        for (std::size_t d = at.size(); d-- > 0;) {
            if (d == first) continue;
            const std::uint64_t chunks_here = std::max<std::uint64_t>(1, rounded_up(space.most[d], layout.edges[d]));
            at[d] = number % chunks_here, number /= chunks_here;
        }
        at[first] = number;
        if (element.left() == 0) return add(address, chunk_bytes, 0);
        if (element.left() < 5) element.damaged("a chunk's record is too short");
        const auto bytes = element.number(static_cast<unsigned>(std::min<std::uint64_t>(8, element.left() - 4)));
        add(address, bytes, element.u32());
    }

    void read_array()
    {
        const auto unlimited = std::ranges::find(space.most, hdf5_nowhere);
        const auto first =
            static_cast<std::size_t>(layout.kind == LayoutKind::extensible_array && unlimited != space.most.end()
                                         ? unlimited - space.most.begin()
                                         : 0);
        const unsigned element_kind = layout.filters.empty() ? 0 : 1;
        const auto visit = [&](std::uint64_t number, Hdf5Cursor element) { add_element(number, element, first); };
        if (layout.kind == LayoutKind::fixed_array)
            walk_fixed_array(walk, layout.address, element_kind, visit);
        else
            walk_extensible_array(walk, layout.address, element_kind, visit);
    }

    /// All chunks, one after the other, without an index.
    void read_implicit()
    {
        std::uint64_t address = layout.address, bytes = chunk_bytes;
        for (std::size_t d = 0; d < at.size(); ++d) {
            const std::uint64_t count = rounded_up(space.most[d], layout.edges[d]);
            if (count > 0 && bytes > walk.file.size() / count) hdf5_damaged(address, "the file is too short");
            bytes *= count;
        }
        for (std::uint64_t i = 0; i < bytes / chunk_bytes; ++i, address += chunk_bytes) {
            std::uint64_t rest = i;
            for (std::size_t d = at.size(); d-- > 0;) {
                const std::uint64_t count = rounded_up(space.most[d], layout.edges[d]);
                at[d] = rest % count, rest /= count;
            }
            add(address, chunk_bytes, 0);
        }
    }

    void read()
    {
        at.assign(grid.dimensions(), 0);
        switch (layout.kind) {
        case LayoutKind::old_btree:
            return read_old_btree();
        case LayoutKind::btree:
            return read_btree();
        case LayoutKind::single:
            return add(layout.address, layout.stored.value_or(chunk_bytes), layout.skipped);
        case LayoutKind::implicit:
            return read_implicit();
        case LayoutKind::fixed_array:
        case LayoutKind::extensible_array:
            return read_array();
        case LayoutKind::compact:
        case LayoutKind::contiguous:
            return;
        }
    }

    /// In a valid file no two chunks share bytes; otherwise a small file could take any memory and time.
    void check()
    {
        // Most bytes that a running writer has not written yet.
        constexpr std::uint64_t not_yet_written = std::uint64_t{4} << 20;
        std::ranges::sort(chunks, {}, &Hdf5Chunk::number);
        std::uint64_t left = walk.file.size() + (walk.file.is_written() ? not_yet_written : 0);
        for (std::size_t i = 0; i < chunks.size(); ++i) {
            const Hdf5Chunk& chunk = chunks[i];
            if (i > 0 && chunks[i - 1].number == chunk.number) hdf5_damaged(chunk.address, "a chunk is there twice");
            if (chunk.bytes > left) hdf5_damaged(chunk.address, "chunks overlap");
            left -= chunk.bytes;
            const bool is_possible =
                layout.filters.empty() ? chunk.bytes == chunk_bytes : chunk_bytes <= hdf5_most_unfiltered(chunk.bytes);
            if (!is_possible) hdf5_damaged(chunk.address, "a chunk has an impossible size");
        }
    }
};

} // namespace

Hdf5Grid::Hdf5Grid(const std::vector<std::uint64_t>& extent, const std::vector<std::uint64_t>& edges)
{
    std::uint64_t all = 1;
    for (std::size_t d = 0; d < extent.size(); ++d) {
        counts_.push_back(rounded_up(extent[d], edges[d]));
        if (counts_[d] > 0 && all > (std::uint64_t{1} << 62) / counts_[d]) hdf5_damaged(0, "a dataset is too large");
        all *= std::max<std::uint64_t>(1, counts_[d]);
    }
}

std::uint64_t Hdf5Grid::number(std::span<const std::uint64_t> chunk) const
{
    std::uint64_t number = 0;
    for (std::size_t d = 0; d < counts_.size(); ++d) number = number * counts_[d] + chunk[d];
    return number;
}

bool Hdf5Grid::contains(std::span<const std::uint64_t> chunk) const
{
    for (std::size_t d = 0; d < counts_.size(); ++d)
        if (chunk[d] >= counts_[d]) return false;
    return true;
}

std::vector<Hdf5Chunk> hdf5_chunks(Hdf5Walk& walk, const Hdf5Layout& layout, const Hdf5Space& space,
                                   const Hdf5Grid& grid, std::uint64_t chunk_bytes)
{
    if (layout.address == hdf5_nowhere) return {};
    Reader reader{walk, layout, space, grid, chunk_bytes};
    reader.read(), reader.check();
    return std::move(reader.chunks);
}

} // namespace oncollide
