#include <oncollide/narrowphase/cook_mesh.hpp>

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include <oncollide/base/checksum.hpp>
#include <oncollide/base/large_vector.hpp>
#include <oncollide/base/output_file.hpp>
#include <oncollide/narrowphase/boxes/obb_tree.hpp>
#include <oncollide/narrowphase/inside/parts.hpp>
#include <oncollide/scenes/cooked/cooked_format.hpp>

namespace oncollide {

namespace {

/// Of fewer all parts are found; of more only those of a closed mesh, which is asked for them.
constexpr std::size_t always_parted = 1 << 17;

/// Bytes that are appended to.
class Bytes {
public:
    template <class Value>
    void add(const Value& value)
    {
        const char* const from = reinterpret_cast<const char*>(&value);
        bytes_.insert(bytes_.end(), from, from + sizeof value);
    }
    void fill_up() { bytes_.resize((bytes_.size() + 7) / 8 * 8); }
    std::string_view from(std::size_t begin) const { return {bytes_.data() + begin, bytes_.size() - begin}; }
    std::size_t size() const { return bytes_.size(); }
    void reserve(std::size_t size) { bytes_.reserve(size); }

private:
    LargeVector<char> bytes_;
};

bool all_floats(const Mesh& mesh)
{
    return std::ranges::all_of(mesh.vertices, [](const Eigen::Vector3d& v) {
        return (v.cast<float>().cast<double>().array() == v.array()).all();
    });
}

class Cook {
public:
    Cook(const Mesh& mesh, std::uint32_t chunk)
        : mesh_(mesh), tree_(mesh), chunk_(std::clamp(chunk, ObbTree::leaf_triangles + 1, most_chunk_triangles)),
          local_(mesh.vertices.size(), none)
    {
        std::memcpy(header_.magic, cooked_magic, sizeof cooked_magic);
        header_.byte_order = cooked_byte_order, header_.version = cooked_version;
        header_.kind = CookedKind::mesh;
        header_.coordinate_bytes = all_floats(mesh) ? 4 : 8;
        header_.triangles = mesh.triangles.size(), header_.vertices = mesh.vertices.size();
        header_.zero_area = mesh.zero_area;
        std::memcpy(header_.low, mesh.bounds.min.data(), sizeof header_.low);
        std::memcpy(header_.high, mesh.bounds.max.data(), sizeof header_.high);
        header_.radius = tree_.radius();
    }

    CookedSize write(const std::filesystem::path& path)
    {
        OutputFile file(path);
        data_.reserve(mesh_.triangles.size() * (header_.coordinate_bytes == 4 ? 20 : 28));
        const auto count = static_cast<std::uint32_t>(mesh_.triangles.size());
        if (count > chunk_)
            add_below(ObbTree::root, 0);
        else
            add_chunk(0, count);
        add_vertices_without_triangles();
        find_topology();

        Bytes top;
        for (const BoxNode& node : nodes_) top.add(node);
        header_.nodes = static_cast<std::uint32_t>(nodes_.size());
        header_.chunks = static_cast<std::uint32_t>(table_.size());
        const std::uint64_t first = sizeof header_ + nodes_.size() * sizeof(BoxNode) +
                                    table_.size() * sizeof(CookedChunkEntry) + parts_.size() * cooked_part_bytes;
        for (CookedChunkEntry& entry : table_) entry.offset += first, top.add(entry);
        for (const PartPoints& part : parts_)
            for (const Eigen::Vector3d& point : part) top.add(std::array{point.x(), point.y(), point.z()});
        header_.top_checksum = checksum(top.from(0));
        header_.file_bytes = first + data_.size();
        const std::string_view header(reinterpret_cast<const char*>(&header_), sizeof header_);
        header_.header_checksum = checksum(header.substr(0, offsetof(CookedHeader, header_checksum)));
        file.write(header), file.write(top.from(0)), file.write(data_.from(0));
        file.commit();
        return {header_.file_bytes, header_.chunks};
    }

private:
    static constexpr std::uint16_t none = 0xffff;
    static_assert(most_chunk_vertices < none);

    /// The node of the parts of box k, and all below it that have more triangles than a chunk. Returns its number.
    std::uint32_t add_below(std::uint32_t index, unsigned k)
    {
        const BoxNode node = tree_.node(tree_.child(index, k));
        const std::uint32_t from = tree_.node(index).child[k];
        const std::size_t place = nodes_.size();
        nodes_.push_back(node);
        for (unsigned lane = 0; lane < node.lanes; ++lane) {
            std::uint32_t& child = nodes_[place].child[lane];
            if (!child && node.count[lane] <= chunk_) {
                add_chunk(node.begin[lane], node.count[lane]);
                continue;
            }
            const std::uint32_t below = add_below(from, lane);
            nodes_[place].child[lane] = below;
        }
        return static_cast<std::uint32_t>(place) + 1;
    }

    void add_chunk(std::uint32_t begin, std::uint32_t count)
    {
        numbers_.clear(), corners_.clear();
        for (std::uint32_t i = 0; i < count; ++i)
            for (const std::uint32_t v : mesh_.triangles[triangle_at(begin + i)]) {
                if (local_[v] == none) local_[v] = static_cast<std::uint16_t>(numbers_.size()), numbers_.push_back(v);
                corners_.push_back(local_[v]);
            }
        const std::size_t at = data_.size();
        add_vertices();
        for (const std::uint16_t corner : corners_) data_.add(corner);
        for (std::uint32_t i = 0; i < count; ++i) data_.add(triangle_at(begin + i));
        data_.fill_up();
        table_.push_back(
            {at, data_.size() - at, checksum(data_.from(at)), count, static_cast<std::uint32_t>(numbers_.size())});
        if (used_.empty()) used_.resize(mesh_.vertices.size());
        for (const std::uint32_t v : numbers_) local_[v] = none, used_[v] = true;
    }
    std::uint32_t triangle_at(std::uint32_t place) const { return nodes_.empty() ? place : tree_.triangle(place); }

    void add_vertices()
    {
        for (const std::uint32_t v : numbers_) {
            const Eigen::Vector3d& p = mesh_.vertices[v];
            if (header_.coordinate_bytes == 4)
                data_.add(std::array{float(p.x()), float(p.y()), float(p.z())});
            else
                data_.add(std::array{p.x(), p.y(), p.z()});
        }
        for (const std::uint32_t v : numbers_) data_.add(v);
    }

    void add_vertices_without_triangles()
    {
        const auto add = [&] {
            if (numbers_.empty()) return;
            const std::size_t at = data_.size();
            add_vertices();
            data_.fill_up();
            table_.push_back(
                {at, data_.size() - at, checksum(data_.from(at)), 0, static_cast<std::uint32_t>(numbers_.size())});
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
        header_.topology = closed ? CookedTopology::closed : CookedTopology::open;
        if (!closed && mesh_.triangles.size() >= always_parted) return;
        parts_ = part_points_of(mesh_);
        header_.parts_known = 1, header_.parts = parts_.size();
    }

    const Mesh& mesh_;
    ObbTree tree_;
    const std::uint32_t chunk_; ///< triangles, at most
    CookedHeader header_{};
    std::vector<BoxNode> nodes_;
    std::vector<CookedChunkEntry> table_; ///< offsets from the first
    std::vector<PartPoints> parts_;
    Bytes data_;
    std::vector<std::uint16_t> local_; ///< by vertex: its number in the chunk at hand
    std::vector<bool> used_;
    std::vector<std::uint32_t> numbers_; ///< of the chunk's vertices
    std::vector<std::uint16_t> corners_;
};

} // namespace

CookedSize cook_mesh(const Mesh& mesh, const std::filesystem::path& path, std::uint32_t chunk)
{
    return Cook(mesh, chunk).write(path);
}

CookedSize check_cooked(const std::filesystem::path& path)
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
    std::error_code ignored;
    return {std::filesystem::file_size(path, ignored), static_cast<std::uint32_t>(mesh->chunks())};
}

} // namespace oncollide
