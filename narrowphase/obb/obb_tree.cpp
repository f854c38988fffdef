#include <oncollide/narrowphase/obb/obb_tree_deform.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <oncollide/narrowphase/obb/fits/box_fit.hpp>
#include <oncollide/narrowphase/obb/fits/triangle_parts.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>

namespace oncollide {

namespace {

/// Boxes of at most this many triangles are fitted. Boxes of more triangles use the mesh's axes: fitting costs ten
/// times as much as computing bounds, and would delay the first result of a large mesh.
constexpr std::size_t most_fitted = BoxFit::most;
/// Each thread keeps working memory for at most this many triangles between nodes.
constexpr std::size_t most_kept = 4096;

/// Above this many triangles a grid makes the upper levels.
constexpr std::size_t most_split = 131072;

std::atomic<std::uint32_t> trees_made = 1;

/// The number of parts of a box. Eight parts of three or four triangles would leave nodes half empty; two or three such
/// parts together fill one.
unsigned parts_of(std::uint32_t count, unsigned most)
{
    constexpr std::uint32_t few = 16, many = 32, in_each = 12;
    return count <= few || count > many ? std::min(most, count) : (count + in_each - 1) / in_each;
}

} // namespace

struct ObbTree::Growing {
    TriangleParts parts; ///< triangles of the box that is split
    BoxFit fit;
};

ObbTree::Growing& ObbTree::growing()
{
    static thread_local Growing of_thread;
    return of_thread;
}

ObbTree::ObbTree(const Mesh& mesh, BoxTotals* totals)
    : mesh_(&mesh), totals_(totals), identity_(trees_made.fetch_add(1, std::memory_order_relaxed)),
      centre_(mesh.bounds.centre()), radius_(radius_around(mesh)), large_(mesh.triangles.size() >= prefetched_from),
      checks_(false), vertices_(mesh.vertices.data()), triangles_(mesh.triangles.data())
{
    make_table();
    if (node(root).leaves) number_triangles();
}

ObbTree::ObbTree(std::shared_ptr<const CookedMesh> mesh, ChunkBudget& budget)
    : mesh_(nullptr), totals_(nullptr), chunked_(std::make_unique<MeshChunks>(std::move(mesh), budget)),
      identity_(trees_made.fetch_add(1, std::memory_order_relaxed)), centre_(chunked_->mesh().bounds().centre()),
      radius_(chunked_->mesh().radius()), large_(false), checks_(true), vertices_(chunked_->vertices()),
      triangles_(chunked_->triangles()), order_(chunked_->order()), blocks_(chunked_->blocks())
{
    make_root(chunked_->mesh().triangles());
}

ObbTree::~ObbTree()
{
    if (totals_) totals_->nodes -= nodes(), totals_->bytes -= bytes();
    for (NodeLine* block : own_blocks_) delete[] block;
}

double ObbTree::radius_around(const Mesh& mesh)
{
    const Eigen::Vector3d centre = mesh.bounds.centre();
    double radius2 = 0;
    const auto away = [&](std::uint32_t v) { return (mesh.vertices[v] - centre).squaredNorm(); };
    for (const Triangle& t : mesh.triangles)
        radius2 = std::max(radius2, std::max(away(t[0]), std::max(away(t[1]), away(t[2]))));
    return radius_from(radius2);
}

/// Makes the tables of an empty tree, and its root.
void ObbTree::make_table()
{
    const std::size_t triangles = mesh_->triangles.size();
    own_blocks_.resize(most_lines(triangles) / lines_per_block + 1);
    blocks_ = own_blocks_.data();
    count(0, own_blocks_.capacity() * sizeof(own_blocks_[0]));
    add_node(triangles > leaf_triangles);
    make_root(triangles);
}

/// Drops all nodes and the table.
void ObbTree::drop_table()
{
    const std::size_t before = bytes();
    const std::uint64_t dropped = nodes();
    for (NodeLine* block : own_blocks_) delete[] block;
    std::vector<NodeLine*>().swap(own_blocks_);
    lines_ = nodes_ = 0;
    count(0 - dropped, bytes() - before);
    identity_ = trees_made.fetch_add(1, std::memory_order_relaxed);
}

void ObbTree::make_root(std::size_t triangles)
{
    BoxNode& node = node_at(blocks_, root);
    set_frame(node, Eigen::Vector3d::Zero(), 2 * radius_); // the corners of the box are farther out than radius_
    const Eigen::Vector3d half = bounds().half_extent();
    set_box(node, 0, {-half, half});
    node.lanes = 1;
    node.leaves = triangles <= leaf_triangles, node.singles = triangles == 1;
    if (node.inner) inner_at(blocks_, root).count[0] = static_cast<std::uint32_t>(triangles);
}

LaneMasks ObbTree::open(Node index, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    if (of_triangles(index)) return open_triangles(index, placement, boxes);
    if (checks_) make_current(index);
    const BoxNode& from = node(index);
    oriented_box_kernel().open(from, placement, boxes);
    return {from.leaves, from.singles};
}

unsigned ObbTree::on_segment(Node index, const SegmentLine& line, float (&entry)[8], unsigned& leaves) const
{
    if (checks_) make_current(index);
    const BoxNode& from = node(index);
    leaves = from.leaves;
    return oriented_box_kernel().node_on_segment(from, line, entry);
}

/// The two boxes of 20 bytes are not stored: computing them from the corners takes as long as opening a node of eight
/// boxes.
LaneMasks ObbTree::open_triangles(Node index, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    std::array<TrianglePoints, leaf_triangles> triangles;
    for (std::uint32_t k = 0; k < leaf_triangles; ++k) triangles[k] = corners(order_[place_of(index) + k]);
    Eigen::Vector3d from = centre_;
    if (placement)
        for (int i = 0; i < 3; ++i) from[i] += placement->from[i];
    oriented_box_kernel().open_triangles(row_of(triangles, from), placement, boxes);
    constexpr std::uint32_t all = (1u << leaf_triangles) - 1;
    return {all, all};
}

void ObbTree::grow_in(const Aabb& box, std::uint32_t triangles)
{
    const Aabb around{box.min - centre_, box.max - centre_};
    std::vector<std::uint32_t> waiting{root};
    while (!waiting.empty()) {
        const std::uint32_t index = waiting.back();
        waiting.pop_back();
        if (chunked_) chunked_->opened(index);
        for (unsigned k = 0; k < node(index).lanes; ++k) {
            if (count_of(index, k) <= std::max(triangles, leaf_triangles)) continue;
            const BoxNode& from = node(index);
            const Eigen::Vector3d centre = centre_of(from, k);
            const Eigen::Vector3d nearest = centre.cwiseMax(around.min).cwiseMin(around.max);
            if ((nearest - centre).norm() <= radius_of(from, k)) waiting.push_back(child(index, k));
        }
    }
}

void ObbTree::copy_order(std::uint32_t begin, std::uint32_t count, std::vector<std::uint32_t>& to) const
{
    to.resize(count);
    const std::lock_guard lock(growing_);
    if (order_)
        std::copy_n(order_ + begin, count, to.begin());
    else
        std::iota(to.begin(), to.end(), begin);
}

void ObbTree::number_triangles()
{
    own_order_.resize(mesh_->triangles.size());
    std::iota(own_order_.begin(), own_order_.end(), 0u);
    order_ = own_order_.data();
    count(0, own_order_.capacity() * sizeof(own_order_[0]));
}

std::uint64_t ObbTree::most_nodes(std::size_t triangles)
{
    return 1 + (triangles > most_split ? triangles : 8 * triangles / 21);
}

std::uint64_t ObbTree::most_lines(std::size_t triangles)
{
    return lines_of(triangles > leaf_triangles) + most_node_lines(triangles, triangles > most_split);
}

/// At most the lines that the tree can use: rays and boxes are small meshes.
std::size_t ObbTree::room_in(std::size_t number) const
{
    return std::min<std::size_t>(lines_per_block, most_lines(mesh_->triangles.size()) - number * lines_per_block);
}

void ObbTree::count(std::uint64_t nodes, std::size_t bytes)
{
    if (totals_) totals_->nodes += nodes, totals_->bytes += bytes;
}

ObbTree::Node ObbTree::add_node(bool inner)
{
    if (chunked_) return chunked_->add_node(grows_in_, inner);
    std::uint32_t index = lines_;
    if (index % lines_per_block + lines_of(inner) > lines_per_block) index += lines_per_block - index % lines_per_block;
    const std::uint32_t block = index / lines_per_block;
    const bool full = !blocks_[block];
    if (full) blocks_[block] = new NodeLine[room_in(block)];
    lines_ = index + lines_of(inner), ++nodes_;
    count(1, full ? room_in(block) * sizeof(NodeLine) : 0);
    make_node(blocks_, index, inner).fitted = deformation_ ? Deformation::never : 0;
    return index;
}

ObbTree::Node ObbTree::grow(Node parent, unsigned k)
{
    const std::lock_guard lock(growing_);
    return grow_locked(parent, k);
}

ObbTree::Node ObbTree::grow_locked(Node parent, unsigned k)
{
    InnerNode& above = inner_at(blocks_, parent);
    if (above.child[k]) return above.child[k]; // another traversal grew it first
    const std::uint32_t begin = above.begin[k], count = above.count[k];
    if (chunked_)
        chunked_->need(grows_in_ = chunked_->chunk_of(begin));
    else if (!order_)
        number_triangles();
    if (count > most_split)
        if (const Node index = grow_by_grid(above, k)) return index;
    Growing& g = growing();
    g.parts.start({vertices_, triangles_, chunked_ ? chunked_->numbers() : nullptr}, centre_, {order_ + begin, count});
    const unsigned parts = parts_of(count, most_lanes);
    g.parts.split(parts);
    bool inner = false;
    for (unsigned part = 0; part < parts; ++part)
        inner |= g.parts.end(part) - (part ? g.parts.end(part - 1) : 0) > leaf_triangles;
    const Node index = add_node(inner);
    BoxNode& node = node_at(blocks_, index);
    set_frame(node, centre_of(above.boxes, k), radius_of(above.boxes, k));
    node.begin = begin;
    for (std::size_t from = 0; from < count; ++node.lanes) {
        const std::size_t to = g.parts.end(node.lanes);
        add_lane(node, from, to, begin);
        from = to;
    }
    fit_lanes(g, node);
    for (std::uint32_t i = 0; i < count; ++i)
        if (std::uint32_t& place = order_[begin + i]; place != g.parts.triangle(i)) place = g.parts.triangle(i);
    if (count > most_kept) g = {}; // nodes this large are rare, and later nodes are smaller
    std::atomic_ref(above.child[k]).store(index, std::memory_order_release);
    return index;
}

/// Grows all levels down to parts of a few thousand triangles. Returns 0 if the grid cannot separate the triangles.
ObbTree::Node ObbTree::grow_by_grid(InnerNode& above, unsigned k)
{
    const Eigen::Vector3d middle = centre_of(above.boxes, k),
                          reach = Eigen::Vector3d::Constant(radius_of(above.boxes, k));
    const Eigen::Vector3d half = mesh_->bounds.half_extent();
    const Aabb around{(middle - reach).cwiseMax(-half), (middle + reach).cwiseMin(half)};
    const std::uint32_t begin = above.begin[k];
    const GridPart all = split_by_grid(*mesh_, centre_, std::span(order_ + begin, above.count[k]), around);
    if (all.parts.empty()) return 0;
    const Node index = add_nodes(all, begin);
    std::atomic_ref(above.child[k]).store(index, std::memory_order_release);
    return index;
}

ObbTree::Node ObbTree::add_nodes(const GridPart& part, std::uint32_t begin)
{
    const Node index = add_node(true);
    InnerNode& inner = inner_at(blocks_, index);
    BoxNode& node = inner.boxes;
    set_frame(node, part.box.centre(), part.box.half_extent().norm());
    for (const GridPart& lane : part.parts) {
        const unsigned k = node.lanes++;
        inner.begin[k] = begin + lane.begin, inner.count[k] = lane.count;
        node.leaves |= static_cast<std::uint8_t>((lane.count <= leaf_triangles) << k);
        node.singles |= static_cast<std::uint8_t>((lane.count == 1) << k);
        set_box(node, k, lane.box);
        if (!lane.parts.empty()) inner.child[k] = add_nodes(lane, begin);
    }
    return index;
}

/// Adds the next box. The box holds the triangles [from, to) of the node, whose triangles begin at position `begin`.
void ObbTree::add_lane(BoxNode& node, std::size_t from, std::size_t to, std::uint32_t begin)
{
    const unsigned k = node.lanes;
    const std::size_t size = to - from;
    if (node.inner) {
        InnerNode& inner = reinterpret_cast<InnerNode&>(node);
        inner.begin[k] = begin + static_cast<std::uint32_t>(from), inner.count[k] = static_cast<std::uint32_t>(size);
    } else {
        node.offsets |= static_cast<std::uint32_t>(from) << 4 * k;
    }
    node.leaves |= static_cast<std::uint8_t>((size <= leaf_triangles) << k);
    node.singles |= static_cast<std::uint8_t>((size == 1) << k);
}

/// Sets the boxes of the node's lanes.
void ObbTree::fit_lanes(Growing& g, BoxNode& node)
{
    const auto size = [&](unsigned k) { return g.parts.end(k) - (k ? g.parts.end(k - 1) : 0); };
    std::array<std::uint32_t, most_lanes> counts{};
    for (unsigned k = 0; k < node.lanes; ++k)
        if (size(k) <= most_fitted) counts[k] = static_cast<std::uint32_t>(size(k));
    const auto corners = [&](unsigned k, std::uint32_t i) -> const TrianglePoints& {
        return g.parts.corners(g.parts.end(k) - counts[k] + i);
    };
    set_boxes(node, g.fit.fit(counts, frame_of(node), corners));
    for (unsigned k = 0; k < node.lanes; ++k) {
        if (counts[k] > 0) continue;
        Aabb box;
        for (std::size_t i = g.parts.end(k) - size(k); i < g.parts.end(k); ++i)
            for (const Eigen::Vector3d& p : g.parts.corners(i)) box.add(p);
        set_box(node, k, box);
    }
}

std::size_t ObbTree::most_bytes(std::size_t triangles)
{
    const std::size_t lines = most_lines(triangles), blocks = lines / lines_per_block + 1;
    return lines * sizeof(NodeLine) + blocks * sizeof(NodeLine*) +
           triangles * (sizeof(std::uint32_t) + 2 * (TriangleParts::bytes_each + sizeof(TrianglePoints)));
}

std::size_t ObbTree::bytes() const
{
    if (chunked_) return chunked_->bytes(); // the tree may grow during this call
    // Blocks are used in order.
    const std::size_t lines = std::min<std::size_t>((lines_ + lines_per_block - 1) / lines_per_block * lines_per_block,
                                                    most_lines(mesh_->triangles.size()));
    return lines * sizeof(NodeLine) + own_blocks_.capacity() * sizeof(own_blocks_[0]) +
           own_order_.capacity() * sizeof(own_order_[0]) + (deformation_ ? deformation_->bytes() : 0);
}

void ObbTree::add_held(std::vector<Held>& to) const
{
    if (chunked_) chunked_->add_held(to);
}

void ObbTree::drop(std::uint32_t of_chunks)
{
    chunked_->drop(of_chunks);
    identity_ = trees_made.fetch_add(1, std::memory_order_relaxed); // invalidates node numbers that callers have kept
}

} // namespace oncollide
