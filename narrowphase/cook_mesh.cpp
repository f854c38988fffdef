#include <oncollide/narrowphase/cook_grids.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/inside/parts.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/scenes/cooked/cooked_format.hpp>
#include <oncollide/scenes/cooked/cooked_writer.hpp>

namespace oncollide {

namespace {

/// A closed mesh always stores its connected parts, which queries need; an open mesh only below this many triangles.
constexpr std::size_t always_parted = 1 << 17;

bool all_floats(const Mesh& mesh)
{
    return std::ranges::all_of(mesh.vertices, [](const Eigen::Vector3d& v) {
        return (v.cast<float>().cast<double>().array() == v.array()).all();
    });
}

/// Counts the triangles without area. Mesh::zero_area is no exact number if the vertices have moved.
std::size_t zero_area(const Mesh& mesh)
{
    const auto flat = [&](const Triangle& t) {
        return collinear(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
    };
    return static_cast<std::size_t>(std::ranges::count_if(mesh.triangles, flat));
}

class Cook {
public:
    Cook(const Mesh& mesh, std::uint32_t chunk)
        : mesh_(mesh), tree_(mesh), chunk_(std::clamp(chunk, ObbTree::leaf_triangles + 1, most_chunk_triangles)),
          local_(mesh.vertices.size(), none)
    {
        file_.header.coordinate_bytes = all_floats(mesh) ? 4 : 8;
        file_.header.triangles = mesh.triangles.size(), file_.header.vertices = mesh.vertices.size();
        file_.header.zero_area = zero_area(mesh);
        file_.set_bounds(mesh.bounds);
        file_.header.radius = tree_.radius();
    }

    CookedSize write(const std::filesystem::path& path)
    {
        file_.data.reserve(mesh_.triangles.size() * (file_.header.coordinate_bytes == 4 ? 20 : 28));
        const auto count = static_cast<std::uint32_t>(mesh_.triangles.size());
        if (count > chunk_)
            add_below(ObbTree::root, 0);
        else
            add_chunk(0, count);
        add_vertices_without_triangles();
        find_topology();
        for (const CookedNode& node : nodes_) file_.nodes.add(node);
        file_.write(path, CookedKind::mesh);
        return {file_.header.file_bytes, file_.header.chunks};
    }

private:
    static constexpr std::uint16_t none = 0xffff;
    static_assert(most_chunk_vertices < none);

    /// Adds the node below box k, and all nodes below it that have more triangles than a chunk. Returns its number;
    /// the root has 0.
    std::uint32_t add_below(ObbTree::Node index, unsigned k)
    {
        const ObbTree::Node from = tree_.child(index, k);
        const std::size_t place = nodes_.size();
        nodes_.push_back(cooked(from));
        for (unsigned lane = 0; lane < tree_.node(from).lanes; ++lane) {
            const std::uint32_t begin = tree_.begin_of(from, lane), count = tree_.count_of(from, lane);
            if (!tree_.is_grown(from, lane) && count <= chunk_) {
                add_chunk(begin, count);
                continue;
            }
            const std::uint32_t below = add_below(from, lane);
            nodes_[place].child[lane] = below;
        }
        return static_cast<std::uint32_t>(place) + 1;
    }
    CookedNode cooked(ObbTree::Node index) const
    {
        const BoxNode& node = tree_.node(index);
        CookedNode to{};
        static_assert(offsetof(BoxNode, begin) == offsetof(CookedNode, begin));
        std::memcpy(&to, &node, offsetof(CookedNode, begin));
        to.lanes = node.lanes, to.leaves = node.leaves, to.singles = node.singles;
        for (unsigned k = 0; k < node.lanes; ++k)
            to.begin[k] = tree_.begin_of(index, k), to.count[k] = tree_.count_of(index, k);
        return to;
    }

    void add_chunk(std::uint32_t begin, std::uint32_t count)
    {
        numbers_.clear(), corners_.clear();
        for (std::uint32_t i = 0; i < count; ++i)
            for (const std::uint32_t v : mesh_.triangles[triangle_at(begin + i)]) {
                if (local_[v] == none) local_[v] = static_cast<std::uint16_t>(numbers_.size()), numbers_.push_back(v);
                corners_.push_back(local_[v]);
            }
        add_vertices();
        file_.data.add(std::span<const std::uint16_t>(corners_));
        for (std::uint32_t i = 0; i < count; ++i) file_.data.add(triangle_at(begin + i));
        file_.end_chunk(count, static_cast<std::uint32_t>(numbers_.size()));
        if (used_.empty()) used_.resize(mesh_.vertices.size());
        for (const std::uint32_t v : numbers_) local_[v] = none, used_[v] = true;
    }
    std::uint32_t triangle_at(std::uint32_t place) const { return nodes_.empty() ? place : tree_.triangle(place); }

    void add_vertices()
    {
        for (const std::uint32_t v : numbers_) {
            const Eigen::Vector3d& p = mesh_.vertices[v];
            if (file_.header.coordinate_bytes == 4)
                file_.data.add(std::array{float(p.x()), float(p.y()), float(p.z())});
            else
                file_.data.add(std::array{p.x(), p.y(), p.z()});
        }
        file_.data.add(std::span<const std::uint32_t>(numbers_));
    }

    void add_vertices_without_triangles()
    {
        const auto add = [&] {
            if (numbers_.empty()) return;
            add_vertices();
            file_.end_chunk(0, static_cast<std::uint32_t>(numbers_.size()));
            numbers_.clear();
        };
        numbers_.clear();
        for (std::uint32_t v = 0; v < used_.size(); ++v) {
            if (used_[v]) continue;
            numbers_.push_back(v);
            if (numbers_.size() == most_chunk_vertices) add();
        }
        add();
    }

    void find_topology()
    {
        const bool closed = is_closed(mesh_);
        file_.header.topology = closed ? CookedTopology::closed : CookedTopology::open;
        if (!closed && mesh_.triangles.size() >= always_parted) return;
        file_.set_parts(part_points_of(mesh_));
    }

    const Mesh& mesh_;
    ObbTree tree_;
    const std::uint32_t chunk_; ///< maximum triangles per chunk
    CookedWriter file_;
    std::vector<CookedNode> nodes_;
    std::vector<std::uint16_t> local_; ///< by vertex: its number in the current chunk
    std::vector<bool> used_;
    std::vector<std::uint32_t> numbers_; ///< vertices of the chunk
    std::vector<std::uint16_t> corners_;
};

std::size_t check_cooked_mesh(const std::filesystem::path& path)
{
    const auto mesh = std::make_shared<const CookedMesh>(path);
    ChunkBudget budget(0);
    ObbTree tree(mesh, budget);
    for (std::uint32_t chunk = 0; chunk < mesh->open()->tree_chunks; ++chunk) {
        tree.chunked()->need(chunk);
        tree.drop(chunk);
    }
    const Mesh whole = mesh->whole();
    if (whole.bounds.centre() != tree.centre() || ObbTree::radius_around(whole) != tree.radius() ||
        (mesh->closed() && *mesh->closed() != is_closed(whole)) ||
        (mesh->open()->parts && *mesh->open()->parts != part_points_of(whole)))
        throw Error(ErrorKind::bad_data,
                    path.string() + ": what it says of the mesh as a whole is wrong; cook it again");
    return mesh->chunks();
}

} // namespace

CookedSize cook_mesh(const Mesh& mesh, const std::filesystem::path& path, std::uint32_t chunk)
{
    return Cook(mesh, chunk).write(path);
}

CookedSize check_cooked(const std::filesystem::path& path)
{
    const CookedKind kind = cooked_kind(path);
    const std::size_t chunks = kind == CookedKind::terrain ? check_cooked_terrain(path)
                               : kind == CookedKind::map   ? check_cooked_map(path)
                                                           : check_cooked_mesh(path);
    std::error_code ignored;
    return {std::filesystem::file_size(path, ignored), static_cast<std::uint32_t>(chunks)};
}

} // namespace oncollide
