#include <oncollide/narrowphase/boxes/obb_tree.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include <oncollide/narrowphase/boxes/box_fit.hpp>
#include <oncollide/narrowphase/boxes/oriented_box.hpp>
#include <oncollide/narrowphase/boxes/triangle_parts.hpp>

namespace oncollide {

namespace {

constexpr unsigned most_lanes = 8;
constexpr std::size_t large_from = 4096; ///< triangles: half a megabyte with their corners and boxes
/// Triangles whose box is fitted. Boxes of more lie along the mesh's axes: fitting costs ten times what looking at
/// bounds does, and of a mesh so large the first answer would wait for it.
constexpr std::size_t most_fitted = 16384;
/// Room for so many is kept from one node to the next, by each thread.
constexpr std::size_t most_kept = 4096;

/// Of more the upper levels come from a grid.
constexpr std::size_t most_split = 131072;

std::atomic<std::uint32_t> trees_made = 1;

} // namespace

struct ObbTree::Growing {
    TriangleParts parts; ///< of the box that grows
    TriangleColumns columns;
};

ObbTree::Growing& ObbTree::growing()
{
    static thread_local Growing of_thread;
    return of_thread;
}

ObbTree::ObbTree(const Mesh& mesh, BoxTotals* totals)
    : mesh_(&mesh), totals_(totals), identity_(trees_made.fetch_add(1, std::memory_order_relaxed)),
      centre_(mesh.bounds.centre()), radius_(radius_around(mesh)), large_(mesh.triangles.size() >= large_from),
      vertices_(mesh.vertices.data()), triangles_(mesh.triangles.data()),
      own_chunks_(most_nodes(mesh.triangles.size()) / chunk + 1)
{
    chunks_ = own_chunks_.data();
    count(0, own_chunks_.capacity() * sizeof(own_chunks_[0]));
    add_node();
    make_root(mesh.bounds, mesh.triangles.size());
    if (node(root).leaves) number_triangles();
}

ObbTree::ObbTree(std::shared_ptr<const CookedMesh> mesh, ChunkBudget& budget)
    : mesh_(nullptr), totals_(nullptr), chunked_(std::make_unique<MeshChunks>(std::move(mesh), budget)),
      identity_(trees_made.fetch_add(1, std::memory_order_relaxed)), centre_(chunked_->mesh().bounds().centre()),
      radius_(chunked_->mesh().radius()), large_(false), vertices_(chunked_->vertices()),
      triangles_(chunked_->triangles()), order_(chunked_->order()), chunks_(chunked_->blocks())
{
    static_assert(chunk == MeshChunks::nodes_per_block);
    make_root(chunked_->mesh().bounds(), chunked_->mesh().triangles());
    if (chunked_->upper_nodes() > 1) at(root).child[0] = 1;
}

ObbTree::~ObbTree()
{
    if (totals_) totals_->nodes -= nodes(), totals_->bytes -= bytes();
    for (BoxNode* nodes : own_chunks_) delete[] nodes;
}

double ObbTree::radius_around(const Mesh& mesh)
{
    const Eigen::Vector3d centre = mesh.bounds.centre();
    double radius = 0;
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t) radius = std::max(radius, (mesh.vertices[v] - centre).squaredNorm());
    return std::sqrt(radius) * (1 + 0x1p-50) + 1e-150;
}

void ObbTree::make_root(const Aabb& bounds, std::size_t triangles)
{
    BoxNode& node = at(root);
    set_frame(node, Eigen::Vector3d::Zero(), 2 * radius_); // the box's corners are farther out
    const Eigen::Vector3d half = bounds.half_extent();
    set_box(node, 0, {-half, half});
    node.lanes = 1, node.begin[0] = 0, node.count[0] = static_cast<std::uint32_t>(triangles);
    node.leaves = node.count[0] <= leaf_triangles, node.singles = node.count[0] == 1;
}

LaneMasks ObbTree::open(Node index, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    if (chunked_) chunked_->opened(index);
    const BoxNode& from = node(index);
    oriented_box_kernel().open(from, placement, boxes);
    return {from.leaves, from.singles};
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
            const BoxNode& from = node(index);
            if (from.count[k] <= std::max(triangles, 1u)) continue;
            const Eigen::Vector3d centre = centre_of(from, k);
            const Eigen::Vector3d nearest = centre.cwiseMax(around.min).cwiseMin(around.max);
            if ((nearest - centre).norm() <= radius_of(from, k)) waiting.push_back(child(index, k));
        }
    }
}

void ObbTree::number_triangles()
{
    own_order_.resize(mesh_->triangles.size());
    std::iota(own_order_.begin(), own_order_.end(), 0u);
    order_ = own_order_.data();
    count(0, own_order_.capacity() * sizeof(own_order_[0]));
}

/// No more than there can be: rays and boxes are small meshes.
std::size_t ObbTree::room_in(std::size_t number) const
{
    return std::min<std::size_t>(chunk, most_nodes(mesh_->triangles.size()) - number * chunk);
}

void ObbTree::count(std::uint64_t nodes, std::size_t bytes)
{
    if (totals_) totals_->nodes += nodes, totals_->bytes += bytes;
}

std::uint32_t ObbTree::add_node()
{
    if (chunked_) return chunked_->add_node(grows_in_);
    const std::uint32_t index = used_.fetch_add(1);
    const bool full = !chunks_[index / chunk];
    if (full) chunks_[index / chunk] = new BoxNode[room_in(index / chunk)];
    count(1, full ? room_in(index / chunk) * sizeof(BoxNode) : 0);
    std::memset(static_cast<void*>(&at(index)), 0, sizeof(BoxNode)); // not the chunk: of most trees few are needed
    return index;
}

std::uint32_t ObbTree::grow(std::uint32_t parent, unsigned k)
{
    const std::lock_guard lock(growing_);
    BoxNode& above = at(parent);
    if (above.child[k]) return above.child[k]; // another walk was first
    const std::uint32_t begin = above.begin[k], count = above.count[k];
    if (chunked_)
        chunked_->need(grows_in_ = chunked_->chunk_of(begin));
    else if (!order_)
        number_triangles();
    if (count > most_split)
        if (const std::uint32_t index = grow_by_grid(above, k)) return index;
    Growing& g = growing();
    g.parts.start({vertices_, triangles_, chunked_ ? chunked_->numbers() : nullptr}, centre_, {order_ + begin, count});
    const std::uint32_t index = add_node();
    BoxNode& node = at(index);
    set_frame(node, centre_of(above, k), radius_of(above, k));
    // A leaf keeps the order of its triangles, which others may be reading.
    if (count > leaf_triangles) g.parts.split(std::min(most_lanes, count));
    for (std::size_t from = 0; from < count; ++node.lanes) {
        const std::size_t to = count > leaf_triangles ? g.parts.end(node.lanes) : from + 1;
        add_lane(g, node, from, to, begin);
        from = to;
    }
    if (count > most_kept) g = {}; // rarely needed again, and then less
    std::atomic_ref(above.child[k]).store(index, std::memory_order_release);
    return index;
}

/// All levels at once down to parts of a few thousand triangles. 0: the grid cannot tell them apart.
std::uint32_t ObbTree::grow_by_grid(BoxNode& above, unsigned k)
{
    const Eigen::Vector3d middle = centre_of(above, k), reach = Eigen::Vector3d::Constant(radius_of(above, k));
    const Eigen::Vector3d half = mesh_->bounds.half_extent();
    const Aabb around{(middle - reach).cwiseMax(-half), (middle + reach).cwiseMin(half)};
    const std::uint32_t begin = above.begin[k];
    const GridPart all = split_by_grid(*mesh_, centre_, std::span(order_ + begin, above.count[k]), around);
    if (all.parts.empty()) return 0;
    const std::uint32_t index = add_nodes(all, begin);
    std::atomic_ref(above.child[k]).store(index, std::memory_order_release);
    return index;
}

std::uint32_t ObbTree::add_nodes(const GridPart& part, std::uint32_t begin)
{
    const std::uint32_t index = add_node();
    BoxNode& node = at(index);
    set_frame(node, part.box.centre(), part.box.half_extent().norm());
    for (const GridPart& lane : part.parts) {
        const unsigned k = node.lanes++;
        node.begin[k] = begin + lane.begin, node.count[k] = lane.count;
        node.leaves |= unsigned(lane.count <= leaf_triangles) << k;
        node.singles |= unsigned(lane.count == 1) << k;
        set_box(node, k, lane.box);
        if (!lane.parts.empty()) node.child[k] = add_nodes(lane, begin);
    }
    return index;
}

void ObbTree::add_lane(Growing& g, BoxNode& node, std::size_t from, std::size_t to, std::uint32_t begin)
{
    const unsigned k = node.lanes;
    const std::size_t size = to - from;
    node.begin[k] = begin + static_cast<std::uint32_t>(from), node.count[k] = static_cast<std::uint32_t>(size);
    node.leaves |= unsigned(size <= leaf_triangles) << k;
    node.singles |= unsigned(size == 1) << k;
    for (std::size_t i = from; i < to; ++i) {
        std::uint32_t& place = order_[begin + i];
        if (place != g.parts.triangle(i)) place = g.parts.triangle(i);
    }
    if (size > most_fitted) {
        Aabb box;
        for (std::size_t i = from; i < to; ++i)
            for (const Eigen::Vector3d& p : g.parts.corners(i)) box.add(p);
        return set_box(node, k, box);
    }
    g.columns.assign(size, [&](std::size_t i) -> const TrianglePoints& { return g.parts.corners(from + i); });
    fit_box(node, k, g.columns, g.parts.bounds(from, to));
}

std::size_t ObbTree::most_bytes(std::size_t triangles)
{
    const std::size_t chunks = most_nodes(triangles) / chunk + 1;
    return most_nodes(triangles) * sizeof(BoxNode) + chunks * sizeof(BoxNode*) +
           triangles * (sizeof(std::uint32_t) + 2 * (TriangleParts::bytes_each + sizeof(TrianglePoints)));
}

std::size_t ObbTree::bytes() const
{
    if (chunked_) return chunked_->bytes(); // it may grow beside this
    // Chunks come one after the other.
    const std::size_t nodes =
        std::min<std::size_t>((used_.load() + chunk - 1) / chunk * chunk, most_nodes(mesh_->triangles.size()));
    return nodes * sizeof(BoxNode) + own_chunks_.capacity() * sizeof(own_chunks_[0]) +
           own_order_.capacity() * sizeof(own_order_[0]);
}

void ObbTree::add_held(std::vector<Held>& to) const
{
    if (chunked_) chunked_->add_held(to);
}

void ObbTree::drop(std::uint32_t of_chunks)
{
    chunked_->drop(of_chunks);
    identity_ = trees_made.fetch_add(1, std::memory_order_relaxed); // places in it are none any more
}

} // namespace oncollide
