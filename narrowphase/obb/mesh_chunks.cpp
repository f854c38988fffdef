#include <oncollide/narrowphase/obb/mesh_chunks.hpp>

#include <algorithm>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include <oncollide/narrowphase/obb/oriented_box.hpp>
#include <oncollide/scenes/cooked/cooked_format.hpp>

namespace oncollide {

static_assert(offsetof(BoxNode, begin) == offsetof(CookedNode, begin));

namespace {

// Chunks begin at multiples of these, so that their arrays begin on pages of their own.
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

// Delegates construction, so that the destructor frees all memory even if the file turns out to be invalid.
MeshChunks::MeshChunks(std::shared_ptr<const CookedMesh> mesh, ChunkBudget& budget)
    : MeshChunks(Empty{}, std::move(mesh), budget)
{
    place_chunks();
    read_upper_nodes();
    link_upper_nodes();
    held_ = top_->bytes() + chunks_.size() * sizeof(Chunk) + upper_ * sizeof(InnerNode);
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
        blocks += most_node_lines(top_->chunks[c].triangles, false) / lines_per_block + 1;
    }
    if (std::max(triangles, vertices) > std::numeric_limits<std::uint32_t>::max())
        throw ChunkFault(ErrorKind::bad_data, mesh_->name() + ": has too many triangles for one mesh");
    blocks += top_->nodes.size() / sizeof(CookedNode) / upper_per_block + 2;
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
    blocks_ = reinterpret_cast<NodeLine**>(memory_.data() + at[4]);
    owner_ = reinterpret_cast<std::uint32_t*>(memory_.data() + at[5]);
}

void MeshChunks::refuse(std::uint32_t node, const char* what) const
{
    throw ChunkFault(ErrorKind::bad_data,
                     fmt::format("{}: node {} of its upper levels {}; cook the file again", mesh_->name(), node, what));
}

void MeshChunks::read_upper_nodes()
{
    const std::span from(top_->nodes);
    nodes_ = upper_ = 1 + static_cast<std::uint32_t>(from.size() / sizeof(CookedNode));
    next_block_ = (upper_ - 1) / upper_per_block + 1;
    for (std::uint32_t block = 0; block < next_block_; ++block)
        blocks_[block] = new NodeLine[std::min(upper_per_block, upper_ - block * upper_per_block) * inner_node_lines];
    make_node(blocks_, 0, true);
    for (std::uint32_t i = 1; i < upper_; ++i) {
        CookedNode node;
        std::memcpy(&node, from.data() + (i - 1) * sizeof node, sizeof node);
        if (node.lanes < 2 || node.lanes > 8) refuse(i, "has no two to eight boxes");
        make_node(blocks_, number_of(i), true).lanes = static_cast<std::uint8_t>(node.lanes);
        std::memcpy(&upper(i).boxes, &node, offsetof(CookedNode, begin));
        std::ranges::copy(node.begin, upper(i).begin), std::ranges::copy(node.count, upper(i).count);
        std::ranges::copy(node.child, upper(i).child);
    }
    above_.resize(upper_);
}

/// Checks that the boxes of a node are valid and hold `expected` triangles, and sets which are leaves.
void MeshChunks::check_upper_node(std::uint32_t index, std::uint64_t expected)
{
    InnerNode& node = upper(index);
    BoxNode& boxes = node.boxes;
    const Eigen::Vector3d origin(boxes.origin[0], boxes.origin[1], boxes.origin[2]);
    const double most = 2 * mesh_->radius() * (1 + 0x1p-20) + 1e-30;
    if (!(origin.norm() <= most && boxes.unit > 0 && boxes.unit <= 8 * most)) refuse(index, "is far from the mesh");
    std::uint64_t count = 0;
    for (unsigned k = 0; k < 8; ++k) {
        if (k >= boxes.lanes ? node.count[k] || node.child[k] || node.begin[k] : node.count[k] == 0)
            refuse(index, "has an empty box, or more than it says");
        if (node.child[k] && node.count[k] <= leaf_triangles) refuse(index, "has a box that has no parts");
        if (node.child[k]) node.begin[k] = 0; // not used
        count += node.count[k];
        boxes.leaves |= static_cast<std::uint8_t>((k < boxes.lanes && node.count[k] <= leaf_triangles) << k);
        boxes.singles |= static_cast<std::uint8_t>((node.count[k] == 1) << k);
    }
    if (count != expected) refuse(index, "has not as many triangles as its box above");
}

/// Checks that the nodes are a tree whose leaves are the chunks in order, and that their counts are valid.
void MeshChunks::link_upper_nodes()
{
    if (upper_ == 1) {
        if (chunks_.size() != 1) refuse(0, "are missing");
        return; // the root's box contains the chunk
    }
    std::vector<Lane> waiting{{0, 0}}; // boxes whose child node or chunk comes next, in reverse order
    std::vector<bool> seen(upper_);
    std::uint32_t chunk = 0, found = 0;
    while (!waiting.empty()) {
        const Lane lane = waiting.back();
        waiting.pop_back();
        const std::uint32_t index = lane.node ? upper(lane.node).child[lane.k] : 1;
        if (index == 0) {
            InnerNode& node = upper(lane.node);
            if (chunk == chunks_.size() || top_->chunks[chunk].triangles != node.count[lane.k])
                refuse(lane.node, "has a box that is not around its chunk");
            node.begin[lane.k] = chunks_[chunk].first;
            chunks_[chunk++].lane = lane;
            continue;
        }
        if (index >= upper_ || seen[index]) refuse(lane.node, "has parts that are no node of its own");
        seen[index] = true, ++found, above_[index] = lane;
        check_upper_node(index, lane.node ? upper(lane.node).count[lane.k] : mesh_->triangles());
        for (unsigned k = upper(index).boxes.lanes; k-- > 0;) waiting.push_back({index, k});
    }
    if (chunk != chunks_.size() || found + 1 != upper_) refuse(0, "are no tree over all chunks");
    upper(0).child[0] = 1;
    for (std::uint32_t i = 0; i < upper_; ++i)
        for (std::uint32_t& child : upper(i).child) child = child ? number_of(child) : 0;
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
    if (there(chunk)) return; // another traversal read it first
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

/// Traversals have relied on the boxes above the chunk; its triangles must be in them.
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
            if (!holds(upper(lane.node).boxes, lane.k, v - centre))
                mesh_->refuse_chunk(chunk, "a vertex is outside its box");
}

void MeshChunks::opened(std::uint32_t node)
{
    if (const std::uint32_t owner = owner_[node / lines_per_block]) return budget_.mark(chunks_[owner - 1].needed);
    const InnerNode& from = inner_at(blocks_, node);
    for (std::uint32_t left = from.boxes.leaves; left; left &= left - 1)
        need(chunk_of(from.begin[__builtin_ctz(left)]));
}

/// Adds a node to the tree of a loaded chunk. Only one thread may call it at a time.
std::uint32_t MeshChunks::add_node(std::uint32_t chunk, bool inner)
{
    Chunk& c = chunks_[chunk];
    if (c.lines_end - c.next_line < lines_of(inner)) {
        const std::uint64_t most = most_node_lines(top_->chunks[chunk].triangles, false);
        const auto lines = static_cast<std::uint32_t>(
            std::min<std::uint64_t>(lines_per_block, most - c.blocks.size() * lines_per_block));
        const std::size_t bytes = lines * sizeof(NodeLine);
        budget_.take(bytes, mesh_->name());
        if (free_blocks_.empty()) free_blocks_.push_back(next_block_++);
        const std::uint32_t block = free_blocks_.back();
        free_blocks_.pop_back();
        blocks_[block] = new NodeLine[lines], owner_[block] = chunk + 1;
        c.blocks.push_back(block), c.held += bytes, held_ += bytes;
        c.next_line = block * lines_per_block, c.lines_end = c.next_line + lines;
    }
    const std::uint32_t number = c.next_line;
    c.next_line += lines_of(inner), ++c.nodes;
    nodes_.fetch_add(1, std::memory_order_relaxed);
    make_node(blocks_, number, inner);
    return number;
}

void MeshChunks::drop(std::uint32_t chunk)
{
    Chunk& c = chunks_[chunk];
    upper(c.lane.node).child[c.lane.k] = 0;
    for (const std::uint32_t block : c.blocks) {
        delete[] blocks_[block];
        blocks_[block] = nullptr, owner_[block] = 0;
        free_blocks_.push_back(block);
    }
    nodes_.fetch_sub(c.nodes, std::memory_order_relaxed);
    c.blocks.clear(), c.nodes = c.next_line = c.lines_end = 0;
    const auto give_back = [&](auto* array, std::uint32_t first, std::uint32_t count) {
        const auto begin = reinterpret_cast<std::byte*>(array + first) - memory_.data();
        memory_.give_back(std::size_t(begin), count * sizeof array[0]);
    };
    const std::uint32_t triangles = top_->chunks[chunk].triangles;
    give_back(vertices_, c.first_vertex, top_->chunks[chunk].vertices);
    give_back(triangles_, c.first, triangles), give_back(order_, c.first, triangles);
    give_back(numbers_, c.first, triangles);
    budget_.give(c.held), held_ -= c.held, c.held = 0;
    c.there.store(false, std::memory_order_release);
}

} // namespace oncollide
