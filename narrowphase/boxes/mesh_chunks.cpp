#include <oncollide/narrowphase/boxes/mesh_chunks.hpp>

#include <algorithm>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include <oncollide/narrowphase/boxes/oriented_box.hpp>
#include <oncollide/scenes/cooked/cooked_format.hpp>

namespace oncollide {

static_assert(sizeof(BoxNode) == sizeof(CookedNode) && offsetof(BoxNode, child) == offsetof(CookedNode, child));

namespace {

// Chunks begin at such multiples, so that their arrays begin on pages of their own.
constexpr std::uint64_t triangle_step = 1024, vertex_step = 512;
static_assert(triangle_step * sizeof(Triangle) % LazyMemory::page == 0 && triangle_step * 4 % LazyMemory::page == 0 &&
              vertex_step * sizeof(Eigen::Vector3d) % LazyMemory::page == 0);

constexpr std::uint64_t up_to(std::uint64_t count, std::uint64_t step)
{
    return (count + step - 1) / step * step;
}

} // namespace

MeshChunks::MeshChunks(Empty, std::shared_ptr<const CookedMesh> mesh, ChunkBudget& budget)
    : mesh_(std::move(mesh)), top_(mesh_->open()), budget_(budget), chunks_(top_->tree_chunks)
{
}

// What an empty one then gets, the destructor frees, where the file turns out to be no good, too.
MeshChunks::MeshChunks(std::shared_ptr<const CookedMesh> mesh, ChunkBudget& budget)
    : MeshChunks(Empty{}, std::move(mesh), budget)
{
    place_chunks();
    add_upper_nodes();
    held_ = top_->bytes() + chunks_.size() * sizeof(Chunk) + upper_ * sizeof(BoxNode);
}

MeshChunks::~MeshChunks()
{
    for (std::uint32_t block = 0; block < next_block_; ++block) delete[] blocks_[block];
    for (const Chunk& chunk : chunks_) budget_.give(chunk.held);
}

void MeshChunks::place_chunks()
{
    std::uint64_t triangles = 0, vertices = 0, blocks = 0;
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
        chunks_[c].first = static_cast<std::uint32_t>(triangles);
        chunks_[c].first_vertex = static_cast<std::uint32_t>(vertices);
        triangles += up_to(top_->chunks[c].triangles, triangle_step);
        vertices += up_to(top_->chunks[c].vertices, vertex_step);
        blocks += top_->chunks[c].triangles / nodes_per_block + 2;
    }
    if (std::max(triangles, vertices) > std::numeric_limits<std::uint32_t>::max())
        throw ChunkFault(ErrorKind::bad_data, mesh_->name() + ": has too many triangles for one mesh");
    blocks += top_->nodes.size() / sizeof(BoxNode) / nodes_per_block + 2;
    std::uint64_t bytes = 0;
    const auto room = [&](std::uint64_t size) { return std::exchange(bytes, up_to(bytes + size, LazyMemory::page)); };
    const std::uint64_t at[] = {room(vertices * sizeof vertices_[0]), room(triangles * sizeof triangles_[0]),
                                room(triangles * sizeof order_[0]),   room(triangles * sizeof numbers_[0]),
                                room(blocks * sizeof blocks_[0]),     room(blocks * sizeof owner_[0])};
    memory_ = LazyMemory(bytes);
    vertices_ = reinterpret_cast<Eigen::Vector3d*>(memory_.data() + at[0]);
    triangles_ = reinterpret_cast<Triangle*>(memory_.data() + at[1]);
    order_ = reinterpret_cast<std::uint32_t*>(memory_.data() + at[2]);
    numbers_ = reinterpret_cast<std::uint32_t*>(memory_.data() + at[3]);
    blocks_ = reinterpret_cast<BoxNode**>(memory_.data() + at[4]);
    owner_ = reinterpret_cast<std::uint32_t*>(memory_.data() + at[5]);
}

/// Checks that they are a tree, each of whose leaves is the next chunk, and that its numbers are such as trees have.
void MeshChunks::add_upper_nodes()
{
    const std::span from(top_->nodes);
    const auto fail = [&](std::uint32_t node, const char* what) {
        throw ChunkFault(ErrorKind::bad_data, fmt::format("{}: node {} of its upper levels {}; cook the file again",
                                                          mesh_->name(), node, what));
    };
    nodes_ = upper_ = 1 + static_cast<std::uint32_t>(from.size() / sizeof(BoxNode));
    next_block_ = (upper_ - 1) / nodes_per_block + 1;
    for (std::uint32_t block = 0; block < next_block_; ++block)
        blocks_[block] = new BoxNode[std::min(nodes_per_block, upper_ - block * nodes_per_block)]();
    for (std::uint32_t i = 1; i < upper_; ++i)
        std::memcpy(&at(i), from.data() + (i - 1) * sizeof(BoxNode), sizeof(BoxNode));
    above_.resize(upper_);
    if (upper_ == 1) {
        if (chunks_.size() != 1) fail(0, "are missing");
        return; // the root's box is around the chunk
    }
    std::vector<Lane> waiting{{0, 0}}; // whose node below, or whose chunk, comes next; the last first
    std::vector<bool> seen(upper_);
    std::uint32_t chunk = 0, found = 0;
    while (!waiting.empty()) {
        const Lane lane = waiting.back();
        waiting.pop_back();
        const std::uint32_t index = lane.node ? at(lane.node).child[lane.k] : 1;
        if (index == 0) {
            BoxNode& node = at(lane.node);
            if (chunk == chunks_.size() || top_->chunks[chunk].triangles != node.count[lane.k])
                fail(lane.node, "has a box that is not around its chunk");
            node.begin[lane.k] = chunks_[chunk].first;
            chunks_[chunk++].lane = lane;
            continue;
        }
        if (index >= upper_ || seen[index]) fail(lane.node, "has parts that are no node of its own");
        seen[index] = true, ++found, above_[index] = lane;
        BoxNode& node = at(index);
        if (node.lanes < 2 || node.lanes > 8) fail(index, "has no two to eight boxes");
        const Eigen::Vector3d origin(node.origin[0], node.origin[1], node.origin[2]);
        const double most = 2 * mesh_->radius() * (1 + 0x1p-20) + 1e-30;
        if (!(origin.norm() <= most && node.unit > 0 && node.unit <= 8 * most)) fail(index, "is far from the mesh");
        std::uint64_t count = 0;
        node.leaves = node.singles = 0;
        for (unsigned k = 0; k < 8; ++k) {
            if (k >= node.lanes ? node.count[k] || node.child[k] || node.begin[k] : node.count[k] == 0)
                fail(index, "has an empty box, or more than it says");
            if (node.child[k] && node.count[k] <= leaf_triangles) fail(index, "has a box that has no parts");
            if (node.child[k]) node.begin[k] = 0; // says nothing
            count += node.count[k];
            node.leaves |= unsigned(k < node.lanes && node.count[k] <= leaf_triangles) << k;
            node.singles |= unsigned(node.count[k] == 1) << k;
        }
        if (count != (lane.node ? at(lane.node).count[lane.k] : mesh_->triangles()))
            fail(index, "has not as many triangles as its box above");
        for (unsigned k = node.lanes; k-- > 0;) waiting.push_back({index, k});
    }
    if (chunk != chunks_.size() || found + 1 != upper_) fail(0, "are no tree over all chunks");
}

std::uint32_t MeshChunks::chunk_of(std::uint32_t triangle) const
{
    const auto after = std::upper_bound(chunks_.begin(), chunks_.end(), triangle,
                                        [](std::uint32_t place, const Chunk& c) { return place < c.first; });
    return static_cast<std::uint32_t>(after - chunks_.begin()) - 1;
}

std::size_t MeshChunks::data_bytes(std::uint32_t chunk) const
{
    const std::uint64_t triangles = top_->chunks[chunk].triangles, vertices = top_->chunks[chunk].vertices;
    return up_to(vertices * sizeof vertices_[0], LazyMemory::page) +
           up_to(triangles * sizeof triangles_[0], LazyMemory::page) +
           2 * up_to(triangles * sizeof order_[0], LazyMemory::page);
}

void MeshChunks::need(std::uint32_t chunk)
{
    if (there(chunk)) return;
    const std::lock_guard lock(reading_);
    Chunk& c = chunks_[chunk];
    if (there(chunk)) return; // another walk was first
    const std::size_t bytes = data_bytes(chunk);
    budget_.take(bytes, mesh_->name());
    try {
        mesh_->read(chunk, read_);
        check_boxes(chunk, read_.vertices);
    } catch (...) {
        budget_.give(bytes);
        throw;
    }
    std::ranges::copy(read_.vertices, vertices_ + c.first_vertex);
    for (std::uint32_t i = 0; i < read_.triangles.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) triangles_[c.first + i][k] = c.first_vertex + read_.triangles[i][k];
        order_[c.first + i] = c.first + i;
        numbers_[c.first + i] = read_.numbers[i];
    }
    c.held = bytes, held_ += bytes;
    c.needed.store(budget_.now(), std::memory_order_relaxed);
    c.there.store(true, std::memory_order_release);
}

/// Walks have gone by the boxes above the chunk; its triangles must be in them.
void MeshChunks::check_boxes(std::uint32_t chunk, std::span<const Eigen::Vector3d> vertices)
{
    const Eigen::Vector3d centre = mesh_->bounds().centre();
    const Aabb& bounds = mesh_->bounds();
    Aabb around;
    for (const Eigen::Vector3d& v : vertices) {
        around.add(v);
        if (!((v - centre).norm() <= mesh_->radius())) mesh_->refuse_chunk(chunk, "a vertex is outside the mesh");
    }
    if ((around.min.array() < bounds.min.array()).any() || (around.max.array() > bounds.max.array()).any())
        mesh_->refuse_chunk(chunk, "a vertex is outside the mesh");
    for (Lane lane = chunks_[chunk].lane; lane.node; lane = above_[lane.node])
        for (const Eigen::Vector3d& v : vertices)
            if (!holds(at(lane.node), lane.k, v - centre)) mesh_->refuse_chunk(chunk, "a vertex is outside its box");
}

void MeshChunks::opened(std::uint32_t node)
{
    if (node >= upper_) {
        const std::uint32_t owner = owner_[node / nodes_per_block];
        return budget_.mark(chunks_[owner - 1].needed);
    }
    const BoxNode& from = at(node);
    for (std::uint32_t left = from.leaves; left; left &= left - 1) need(chunk_of(from.begin[__builtin_ctz(left)]));
}

/// Of the tree of a chunk that is there. One thread at a time.
std::uint32_t MeshChunks::add_node(std::uint32_t chunk)
{
    Chunk& c = chunks_[chunk];
    if (c.last_room == 0) {
        // A box holds a triangle at least, so that there are no more nodes than these.
        const auto made = static_cast<std::uint32_t>(c.blocks.size()) * nodes_per_block;
        const std::uint32_t room = std::min(nodes_per_block, top_->chunks[chunk].triangles + 1 - made);
        const std::size_t bytes = room * sizeof(BoxNode);
        budget_.take(bytes, mesh_->name());
        if (free_blocks_.empty()) free_blocks_.push_back(next_block_++);
        const std::uint32_t block = free_blocks_.back();
        free_blocks_.pop_back();
        blocks_[block] = new BoxNode[room](), owner_[block] = chunk + 1;
        c.blocks.push_back(block), c.last_room = room, c.held += bytes, held_ += bytes;
    }
    const std::uint32_t in_block = std::min(
        nodes_per_block, top_->chunks[chunk].triangles + 1 - (std::uint32_t(c.blocks.size()) - 1) * nodes_per_block);
    nodes_.fetch_add(1, std::memory_order_relaxed);
    return c.blocks.back() * nodes_per_block + (in_block - c.last_room--);
}

void MeshChunks::drop(std::uint32_t chunk)
{
    Chunk& c = chunks_[chunk];
    at(c.lane.node).child[c.lane.k] = 0;
    std::uint32_t nodes = 0;
    for (const std::uint32_t block : c.blocks) {
        delete[] blocks_[block];
        blocks_[block] = nullptr, owner_[block] = 0;
        free_blocks_.push_back(block), nodes += nodes_per_block;
    }
    const std::uint32_t triangles = top_->chunks[chunk].triangles;
    if (!c.blocks.empty()) nodes = std::min(nodes, triangles + 1) - c.last_room;
    nodes_.fetch_sub(nodes, std::memory_order_relaxed);
    c.blocks.clear(), c.last_room = 0;
    const auto give_back = [&](auto* array, std::uint32_t first, std::uint32_t count) {
        const auto begin = reinterpret_cast<std::byte*>(array + first) - memory_.data();
        memory_.give_back(std::size_t(begin), count * sizeof array[0]);
    };
    give_back(vertices_, c.first_vertex, top_->chunks[chunk].vertices);
    give_back(triangles_, c.first, triangles), give_back(order_, c.first, triangles);
    give_back(numbers_, c.first, triangles);
    budget_.give(c.held), held_ -= c.held, c.held = 0;
    c.there.store(false, std::memory_order_release);
}

} // namespace oncollide
