#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <oncollide/scenes/files/assembly/part_placer.hpp>
#include <oncollide/scenes/files/gltf/gltf_accessor.hpp>
#include <oncollide/scenes/files/gltf/gltf_nodes.hpp>

namespace oncollide {

namespace {

using Document = GltfDocument;

/// A part of a mesh: corners of triangles. Points and lines are ignored.
struct Primitive {
    Node node;
    GltfAccessor positions;
    std::optional<GltfAccessor> indices;
    enum Mode { triangles = 4, strip = 5, fan = 6 } mode;

    std::size_t corners() const { return indices ? indices->size() : positions.size(); }
    std::size_t count() const { return mode == triangles ? corners() / 3 : corners() - 2; }
    /// The corners of triangle i, with the winding that the format gives it.
    std::array<std::size_t, 3> triangle(std::size_t i) const
    {
        if (mode == triangles) return {3 * i, 3 * i + 1, 3 * i + 2};
        if (mode == fan) return {i + 1, i + 2, 0};
        return {i, i + 1 + i % 2, i + 2 - i % 2};
    }
};

class GltfReader {
public:
    explicit GltfReader(const MeshSource& source)
        : document_(source), buffers_(document_), meshes_(document_.all(Document::meshes).size()), expansion_(source)
    {
    }

    RawMesh read()
    {
        WeldedMesh whole;
        each_mesh([&](std::uint32_t, std::uint32_t mesh, const Eigen::Affine3d& pose) { add(mesh, pose, whole); });
        return whole.take();
    }

    RawAssembly read_parts(double scale, int threads)
    {
        PartPlacer placer(meshes_.size());
        each_mesh([&](std::uint32_t node, std::uint32_t mesh, const Eigen::Affine3d& pose) {
            if (meshes_[mesh]->empty()) return;
            spend(1);
            if (!placer.place(node, mesh, Eigen::Scaling(scale) * pose))
                document_.all(Document::nodes)[node].fail("it places its mesh beyond 1e15 m");
        });
        return placer.take(
            tree_.parents, [this](std::uint32_t node) { return name_of(node); },
            [this](std::uint32_t mesh, const Eigen::Affine3d& pose, WeldedMesh& to) { add(mesh, pose, to); }, threads);
    }

private:
    /// Calls visit(node, mesh, pose) for each visible node with a mesh, from the roots down; reads the mesh before.
    template <class Visit>
    void each_mesh(Visit visit)
    {
        const std::vector<Node>& nodes = document_.all(Document::nodes);
        tree_ = node_tree(document_);
        std::vector<Eigen::Affine3d> poses(nodes.size());
        for (const std::uint32_t i : tree_.order) {
            if (!tree_.shown[i]) continue;
            poses[i] = pose_of(nodes[i]);
            if (tree_.parents[i] != no_node) poses[i] = poses[tree_.parents[i]] * poses[i];
            if (nodes[i].has("mesh")) visit(i, read_mesh(nodes[i]["mesh"]), poses[i]);
        }
    }

    std::string name_of(std::uint32_t i) const
    {
        const Node& node = document_.all(Document::nodes)[i];
        if (node.has("name") && node["name"].is_text() && !node["name"].text().empty())
            return std::string(node["name"].text());
        if (node.has("mesh")) {
            const Node& mesh = document_.at(Document::meshes, node["mesh"]);
            if (mesh.has("name") && mesh["name"].is_text() && !mesh["name"].text().empty())
                return std::string(mesh["name"].text());
        }
        return fmt::format("node {}", i);
    }

    /// Index of a mesh, which is read once even if it is placed several times.
    std::uint32_t read_mesh(const Node& number)
    {
        const std::size_t i = document_.index(Document::meshes, number);
        if (std::optional<std::vector<Primitive>>& parts = meshes_[i]; !parts) {
            parts.emplace();
            for (const Node& node : list_of(document_.at(Document::meshes, number)["primitives"]))
                if (std::optional<Primitive> part = primitive(node)) parts->push_back(std::move(*part));
        }
        return static_cast<std::uint32_t>(i);
    }

    std::optional<Primitive> primitive(const Node& node)
    {
        const std::uint64_t mode = node.has("mode") ? node["mode"].natural() : std::uint64_t(Primitive::triangles);
        if (mode > Primitive::fan) node.fail(fmt::format("a primitive has mode {}; modes are 0 to 6", mode));
        if (mode < Primitive::triangles) return {};
        Primitive part{node,
                       GltfAccessor::of_positions(document_, buffers_, node["attributes"]["POSITION"]),
                       {},
                       static_cast<Primitive::Mode>(mode)};
        spend(part.positions.replaced());
        if (node.has("indices")) {
            part.indices = GltfAccessor::of_corners(document_, buffers_, node["indices"]);
            spend(part.indices->replaced());
        }
        const std::size_t corners = part.corners();
        if (mode == Primitive::triangles ? corners % 3 != 0 : corners < 3)
            node.fail(fmt::format("{} corners make no whole triangles", corners));
        return part;
    }

    void add(std::uint32_t mesh, const Eigen::Affine3d& pose, WeldedMesh& to)
    {
        for (const Primitive& part : *meshes_[mesh]) add(part, pose, to);
    }

    void add(const Primitive& part, const Eigen::Affine3d& pose, WeldedMesh& to)
    {
        spend(1 + part.count());
        const bool mirrored = pose.linear().determinant() < 0;
        for (std::size_t i = 0; i < part.count(); ++i) {
            Triangle t;
            const std::array<std::size_t, 3> corners = part.triangle(i);
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t v = part.indices ? part.indices->corner(corners[k]) : corners[k];
                if (v >= part.positions.size())
                    part.node.fail(fmt::format("triangle {} uses vertex {}, but there are {} vertices", i, v,
                                               part.positions.size()));
                const std::size_t known = to.weld.size();
                t[k] = to.weld.add(pose * part.positions.position(v));
                spend(to.weld.size() - known);
            }
            to.add(t, mirrored);
        }
    }

    void spend(std::uint64_t pieces) { expansion_.spend(pieces, buffers_.bytes_read()); }

    GltfDocument document_;
    GltfBuffers buffers_;
    std::vector<std::optional<std::vector<Primitive>>> meshes_;
    NodeTree tree_;
    ExpansionLimit expansion_;
};

} // namespace

RawMesh read_gltf(const MeshSource& source)
{
    return GltfReader(source).read();
}

RawAssembly read_gltf_parts(const MeshSource& source, double scale, int threads)
{
    return GltfReader(source).read_parts(scale, threads);
}

} // namespace oncollide
