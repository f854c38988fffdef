#include <oncollide/scenes/cooked/cooked_map.hpp>

#include <algorithm>
#include <bit>
#include <limits>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/cooked/cooked_writer.hpp>

namespace oncollide {

namespace {

using Node = CellTree::Node;
static_assert(sizeof(Node) == cooked_node_bytes(CookedKind::map));

constexpr std::uint64_t up_to_step(std::uint64_t nodes)
{
    return (nodes + MapChunks::step - 1) / MapChunks::step * MapChunks::step;
}

std::uint32_t octants_in(const Node& node)
{
    return CellTree::bits_in(node.inner);
}

/// Calls visit(octant) for the octants that have octants of their own.
template <class Visit>
void each_inner(const Node& node, Visit visit)
{
    for (unsigned left = node.inner; left; left &= left - 1) visit(static_cast<unsigned>(std::countr_zero(left)));
}

} // namespace

CookedMap::CookedMap(const std::filesystem::path& path) : file_(path)
{
    const CookedFile::Opened opened = file_.open(CookedKind::map);
    auto record = opened.record();
    record_ = take<CookedMapRecord>(record);
    const CellBox bounds({record_.low[0], record_.low[1], record_.low[2]},
                         {record_.high[0], record_.high[1], record_.high[2]});
    const CellBox grid(CellTree::top_cube.octant(0));
    if (!(record_.resolution >= 1e-6 && record_.resolution <= 1e6) || record_.unknown_is_solid > 1 || record_.none ||
        bounds.empty() || !grid.contains(bounds))
        file_.refuse("has an impossible grid");
    const Eigen::Vector3d low = bounds.low.cast<double>() * record_.resolution,
                          high = bounds.high.cast<double>() * record_.resolution;
    if (std::memcmp(opened.header.low, low.data(), sizeof opened.header.low) != 0 ||
        std::memcmp(opened.header.high, high.data(), sizeof opened.header.high) != 0)
        file_.refuse("has bounds that do not match its grid");
    grid_ = {record_.first, record_.inner, record_.occupied, record_.free, record_.solid};
    top_.resize(opened.header.nodes);
    auto nodes = opened.nodes();
    take(nodes, std::span(top_));
    place_chunks(opened);
    check_top();
}

void CookedMap::place_chunks(const CookedFile::Opened& opened)
{
    handle_ = opened.handle, checksum_ = opened.header.header_checksum, table_ = opened.table();
    file_.check_table(opened, table_, [&](const CookedChunkEntry& entry, std::size_t chunk) {
        if (entry.triangles == 0 || entry.triangles > most_chunk_nodes || entry.vertices) file_.refuse_entry(chunk);
        return entry.triangles * sizeof(Node);
    });
    std::uint64_t next = up_to_step(top_.size()), nodes = top_.size();
    for (const CookedChunkEntry& entry : table_) {
        chunks_.push_back({static_cast<std::uint32_t>(next)});
        next += up_to_step(entry.triangles), nodes += entry.triangles;
    }
    if (next > std::numeric_limits<std::uint32_t>::max() || nodes != opened.header.triangles)
        file_.refuse("has impossible counts");
    end_ = static_cast<std::uint32_t>(next);
}

/// Checks that the octants of each node of the top follow the octants before them, in the top or in the current chunk.
void CookedMap::check_top()
{
    const auto fail = [&] { file_.refuse("has upper levels that do not form an octree"); };
    const bool one_state = grid_.inner == 0;
    if (grid_.free != (one_state && !grid_.occupied ? 0xff : 0xfe) ||
        (one_state ? grid_.occupied > 1 : grid_.inner != 1 || grid_.occupied))
        fail();
    std::vector<MapCell> cubes(top_.size());
    std::uint32_t next = 0;
    std::size_t chunk = 0;
    const auto take_octants = [&](const Node& node, const MapCell& cube) {
        if (!node.inner) return;
        const std::uint32_t count = octants_in(node);
        if (node.first == next && next + count <= top_.size()) {
            each_inner(node, [&](unsigned k) { cubes[next++] = cube.octant(k); });
            return;
        }
        const auto is_next = [&](std::size_t c) {
            return c < chunks_.size() && node.first == chunks_[c].first + chunks_[c].entries;
        };
        if (chunk + 1 < chunks_.size() && chunks_[chunk].entries > 0 && !is_next(chunk)) ++chunk;
        if (!is_next(chunk)) fail();
        if (chunks_[chunk].entries == 0) chunks_[chunk].entry = entries_.size();
        each_inner(node, [&](unsigned k) { entries_.push_back({cube.octant(k), bool(node.solid >> k & 1)}); });
        chunks_[chunk].entries += count;
        if (chunks_[chunk].entries > table_[chunk].triangles) fail();
    };
    take_octants(grid_, CellTree::top_cube);
    for (std::size_t i = 0; i < top_.size(); ++i) {
        if (i >= next || why_not_node(top_[i], cubes[i])) fail();
        take_octants(top_[i], cubes[i]);
    }
    if (next != top_.size() ||
        (chunks_.empty() ? !entries_.empty() : chunk + 1 != chunks_.size() || chunks_[chunk].entries == 0))
        fail();
    const CellTree tree(record_.unknown_is_solid);
    const auto check_solid = [&](const Node& node) {
        unsigned solid = tree.whole(node);
        std::uint32_t at = node.first;
        each_inner(node, [&](unsigned k) {
            const bool here = at < top_.size() ? top_[at++].solid != 0 : node.solid >> k & 1;
            solid |= unsigned(here) << k;
        });
        if (solid != node.solid) fail();
    };
    for (const Node& node : top_) check_solid(node);
    check_solid(grid_);
}

/// Returns why a node is invalid; null: valid. Does not check the position of its octants and the mask `solid`.
const char* CookedMap::why_not_node(const Node& node, const MapCell& cube) const
{
    const unsigned inner = node.inner, occupied = node.occupied, free = node.free;
    if ((inner & occupied) || (inner & free) || (occupied & free)) return "an octant has two states";
    if (occupied == 0xff || free == 0xff || !(inner | occupied | free)) return "a node has one state";
    if (inner ? cube.side < 4 : node.first != 0) return "a cell has octants";
    const auto inside = [&](const MapCell& cell) {
        const std::int32_t low[3] = {cell.x, cell.y, cell.z};
        bool within = true;
        for (int i = 0; i < 3; ++i) within &= low[i] >= record_.low[i] && low[i] + cell.side <= record_.high[i];
        return within;
    };
    if (inside(cube)) return nullptr;
    for (unsigned left = record_.unknown_is_solid ? occupied | free : occupied; left; left &= left - 1)
        if (!inside(cube.octant(static_cast<unsigned>(std::countr_zero(left))))) return "a cell is outside the bounds";
    return nullptr;
}

std::vector<CookedMap::Node> CookedMap::read(std::size_t number) const
{
    ONCOLLIDE_ASSERT(number < chunks_.size());
    const std::vector<std::byte> bytes = file_.read(*handle_, table_[number], number, table_.size());
    std::vector<Node> nodes(bytes.size() / sizeof(Node));
    std::memcpy(static_cast<void*>(nodes.data()), bytes.data(), bytes.size());
    const auto fail = [&](const char* why) { file_.refuse_chunk(number, table_.size(), why); };
    const Chunk& chunk = chunks_[number];
    std::vector<MapCell> cubes(nodes.size());
    for (std::size_t i = 0; i < chunk.entries; ++i) cubes[i] = entries_[chunk.entry + i].cube;
    std::size_t next = chunk.entries;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (i >= next) fail("a node is not part of the octree");
        if (const char* why = why_not_node(nodes[i], cubes[i])) fail(why);
        if (!nodes[i].inner) continue;
        if (nodes[i].first != chunk.first + next || next + octants_in(nodes[i]) > nodes.size())
            fail("a node's octants are in the wrong place");
        each_inner(nodes[i], [&](unsigned k) { cubes[next++] = cubes[i].octant(k); });
    }
    const CellTree tree(record_.unknown_is_solid);
    for (std::size_t i = nodes.size(); i-- > 0;) {
        unsigned solid = tree.whole(nodes[i]);
        std::size_t at = nodes[i].first - chunk.first;
        each_inner(nodes[i], [&](unsigned k) { solid |= unsigned(nodes[at++].solid != 0) << k; });
        if (solid != nodes[i].solid || (i < chunk.entries && (solid != 0) != entries_[chunk.entry + i].solid))
            fail("a node's mask of occupied octants is wrong");
    }
    return nodes;
}

CookedMapChunks::CookedMapChunks(std::shared_ptr<const CookedMap> cooked, ChunkBudget* budget)
    : CookedMapChunks(cooked, budget ? nullptr : std::make_unique<ChunkBudget>(0), budget)
{
}

CookedMapChunks::CookedMapChunks(std::shared_ptr<const CookedMap> cooked, std::unique_ptr<ChunkBudget> own,
                                 ChunkBudget* budget)
    : MapChunks(cooked->chunks(), up_to_step(std::max(cooked->end(), 1u)) / step, own ? *own : *budget),
      cooked_(std::move(cooked)), own_(std::move(own)), budget_(own_ ? *own_ : *budget),
      memory_(std::max<std::size_t>(cooked_->end(), 1) * sizeof(Node))
{
    nodes_ = reinterpret_cast<Node*>(memory_.data());
    ONCOLLIDE_ASSERT(cooked_->top().size() <= cooked_->end() && cooked_->end() <= chunk_of_.size() * step);
    std::ranges::copy(cooked_->top(), nodes_);
    for (std::size_t chunk = 0; chunk < chunks_.size(); ++chunk) {
        const std::uint32_t first = cooked_->first(chunk);
        for (std::uint32_t at = first; at < first + cooked_->nodes(chunk); at += step)
            chunk_of_[at / step] = static_cast<std::uint32_t>(chunk) + 1;
    }
}

CookedMapChunks::~CookedMapChunks()
{
    budget_.give(held_);
}

OccupancyMap CookedMapChunks::map(std::shared_ptr<const CookedMap> cooked, ChunkBudget* budget)
{
    const CookedMapRecord& record = cooked->record();
    const CellBox bounds({record.low[0], record.low[1], record.low[2]},
                         {record.high[0], record.high[1], record.high[2]});
    const Node grid = cooked->grid();
    return MapAccess::make(
        CellTree(std::make_shared<CookedMapChunks>(std::move(cooked), budget), grid, record.unknown_is_solid),
        record.resolution, bounds);
}

std::size_t CookedMapChunks::bytes_of(std::uint32_t chunk) const
{
    return up_to_step(cooked_->nodes(chunk)) * sizeof(Node);
}

void CookedMapChunks::need(std::uint32_t number) const
{
    ONCOLLIDE_ASSERT(number < chunks_.size());
    const std::lock_guard lock(reading_);
    Chunk& chunk = chunks_[number];
    if (chunk.there.load(std::memory_order_acquire)) return;
    budget_.take(bytes_of(number), cooked_->file().name());
    try {
        std::ranges::copy(cooked_->read(number), nodes_ + cooked_->first(number));
    } catch (...) {
        budget_.give(bytes_of(number));
        throw;
    }
    held_ += bytes_of(number);
    chunk.needed.store(budget_.now(), std::memory_order_relaxed);
    chunk.there.store(true, std::memory_order_release);
}

void CookedMapChunks::need_all() const
{
    for (std::uint32_t chunk = 0; chunk < chunks_.size(); ++chunk) need(chunk);
}

void CookedMapChunks::add_held(std::vector<Held>& to) const
{
    for (std::uint32_t chunk = 0; chunk < chunks_.size(); ++chunk)
        if (chunks_[chunk].there) to.push_back({chunks_[chunk].needed.load(std::memory_order_relaxed), chunk});
}

void CookedMapChunks::drop(std::uint32_t chunk)
{
    ONCOLLIDE_ASSERT(chunk < chunks_.size());
    if (!chunks_[chunk].there.exchange(false)) return;
    memory_.give_back(cooked_->first(chunk) * sizeof(Node), cooked_->nodes(chunk) * sizeof(Node));
    budget_.give(bytes_of(chunk)), held_ -= bytes_of(chunk);
}

CookedMapChunks* cooked_chunks(const OccupancyMap& map)
{
    return static_cast<CookedMapChunks*>(MapAccess::cells(map).chunks()); // there are no other chunks
}

namespace {

/// Splits the nodes of a map into a top and chunks, in the order that CookedMap expects.
class MapParts {
public:
    MapParts(const CellTree& cells, std::uint32_t most) : cells_(cells), most_(most), grid_(cells.top())
    {
        divide(grid_, 0, true);
        for (std::size_t i = 0; i < top_.size(); ++i) divide(top_[i], i, false);
        std::uint64_t next = up_to_step(top_.size());
        for (Part& part : parts_) {
            part.first = static_cast<std::uint32_t>(next), next += up_to_step(part.nodes);
            std::uint32_t at = part.first;
            for (const Root& root : part.roots) (root.grid ? grid_ : top_[root.number]).first = at, at += root.octants;
        }
    }

    void add_to(CookedWriter& file)
    {
        file.nodes.add(std::span<const Node>(top_));
        file.header.triangles = top_.size();
        for (const Part& part : parts_) {
            std::vector<Node> nodes = part.begin;
            for (std::size_t i = 0; i < nodes.size(); ++i) {
                const Node node = nodes[i];
                nodes[i].first = node.inner ? part.first + static_cast<std::uint32_t>(nodes.size()) : 0;
                each_inner(node, [&](unsigned k) { nodes.push_back(cells_.below(node, k)); });
            }
            file.data.add(std::span<const Node>(nodes));
            file.end_chunk(static_cast<std::uint32_t>(nodes.size()));
            file.header.triangles += nodes.size();
        }
    }
    const Node& grid() const { return grid_; }

private:
    struct Root {
        bool grid;
        std::size_t number; ///< index in the top
        std::uint32_t octants;
    };
    struct Part {
        std::uint32_t first = 0, nodes = 0;
        std::vector<Root> roots;
        std::vector<Node> begin;
    };

    /// Number of descendants of a node; if they do not fit into a chunk, some larger number.
    std::uint32_t below(const Node& node) const
    {
        std::uint32_t nodes = octants_in(node);
        for (unsigned k = 0; k < 8 && nodes <= most_; ++k)
            if (node.inner >> k & 1) nodes += below(cells_.below(node, k));
        return nodes;
    }
    /// Puts the octants of a node into the top or into a chunk.
    void divide(const Node of, std::size_t number, bool grid)
    {
        Node& node = grid ? grid_ : top_[number];
        node.first = 0;
        if (!node.inner) return;
        const std::uint32_t nodes = below(of);
        if (nodes > most_) {
            node.first = static_cast<std::uint32_t>(top_.size());
            each_inner(of, [&](unsigned k) { top_.push_back(cells_.below(of, k)); });
            return;
        }
        if (parts_.empty() || parts_.back().nodes + nodes > most_) parts_.emplace_back();
        Part& part = parts_.back();
        part.nodes += nodes, part.roots.push_back({grid, number, octants_in(of)});
        each_inner(of, [&](unsigned k) { part.begin.push_back(cells_.below(of, k)); });
    }

    const CellTree& cells_;
    const std::uint32_t most_; ///< nodes per chunk
    Node grid_;
    std::vector<Node> top_;
    std::vector<Part> parts_;
};

} // namespace

void add_map(const OccupancyMap& map, std::uint32_t most_in_chunk, CookedWriter& file)
{
    const CellTree& cells = MapAccess::cells(map);
    MapParts parts(cells, most_in_chunk);
    parts.add_to(file);
    file.set_bounds(map.bounds());
    file.header.coordinate_bytes = 8;
    CookedMapRecord record{};
    record.resolution = map.resolution();
    std::copy_n(MapAccess::cell_bounds(map).low.data(), 3, record.low),
        std::copy_n(MapAccess::cell_bounds(map).high.data(), 3, record.high);
    record.unknown_is_solid = cells.unknown_is_solid();
    const Node& grid = parts.grid();
    record.first = grid.first;
    record.inner = grid.inner, record.occupied = grid.occupied, record.free = grid.free, record.solid = grid.solid;
    file.record.add(record);
}

} // namespace oncollide
