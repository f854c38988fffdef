#include <map>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <oncollide/base/text/file_warning.hpp>
#include <oncollide/scenes/files/assembly/part_placer.hpp>
#include <oncollide/scenes/files/gltf/gltf_instances.hpp>
#include <oncollide/scenes/files/gltf/gltf_nodes.hpp>
#include <oncollide/scenes/files/gltf/gltf_primitive.hpp>

namespace oncollide {

namespace {

using Document = GltfDocument;

class GltfReader {
public:
    GltfReader(const MeshSource& source, std::size_t most_parts)
        : document_(source), buffers_(document_), expansion_(source, most_parts), nodes_(document_.all(Document::nodes))
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
        PartPlacer placer;
        each_mesh([&](std::uint32_t node, std::uint32_t mesh, const Eigen::Affine3d& pose) {
            if (meshes_[mesh].empty()) return;
            expansion_.spend(1, buffers_.bytes_read());
            if (!placer.place(node, mesh, Eigen::Scaling(scale) * pose))
                nodes_[node].fail("it places its mesh beyond 1e15 m");
        });
        RawAssembly assembly = placer.take(
            tree_.parents, [this](std::uint32_t node) { return name_of(node); },
            [this](std::uint32_t mesh, const Eigen::Affine3d& pose, WeldedMesh& to) { add(mesh, pose, to); }, threads);
        add_extras(assembly.parts);
        return assembly;
    }

private:
    /// Calls visit(node, mesh, pose) from the roots down, for each visible node with a mesh and for each of its
    /// instances; reads the mesh before the call.
    template <class Visit>
    void each_mesh(Visit visit)
    {
        tree_ = node_tree(document_);
        std::vector<Eigen::Affine3d> poses(nodes_.size());
        std::size_t skins = 0;
        for (const std::uint32_t i : tree_.order) {
            if (!tree_.shown[i]) continue;
            poses[i] = pose_of(nodes_[i]);
            if (tree_.parents[i] != no_node) poses[i] = poses[tree_.parents[i]] * poses[i];
            if (!nodes_[i].has("mesh")) continue;
            skins += nodes_[i].has("skin");
            const std::uint32_t mesh = read_mesh(nodes_[i]);
            const GltfInstances instances(document_, buffers_, nodes_[i]);
            expansion_.expect_parts(instances.size(), instances.written()), expansion_.expect(instances.size());
            for (std::size_t k = 0; k < instances.size(); ++k) visit(i, mesh, poses[i] * instances.pose(k));
        }
        if (skins > 0)
            warn_of_file(document_.source().name,
                         fmt::format("{} node{} a skin, which is not applied: the mesh stands as it is stored, at the "
                                     "node's pose",
                                     skins, skins == 1 ? " has" : "s have"));
    }

    void add_extras(std::vector<RawPart>& parts) const
    {
        constexpr std::size_t most = 4000; // bytes: instances may copy it a hundred thousand times
        std::size_t left_out = 0;
        for (RawPart& part : parts) {
            if (!nodes_[part.node].has("extras")) continue;
            const std::string_view extras = nodes_[part.node]["extras"].source();
            if (extras.size() <= most)
                part.extras = extras;
            else
                ++left_out;
        }
        if (left_out > 0)
            warn_of_file(document_.source().name,
                         fmt::format("the \"extras\" of {} part{} are longer than {} bytes, and left out", left_out,
                                     left_out == 1 ? "" : "s", most));
    }

    std::string_view name_of(std::uint32_t i) const
    {
        const auto own = [](const Node& of) {
            return of.has("name") && of["name"].is_text() ? of["name"].text() : std::string_view{};
        };
        const std::string_view name = own(nodes_[i]);
        return name.empty() && nodes_[i].has("mesh") ? own(document_.at(Document::meshes, nodes_[i]["mesh"])) : name;
    }

    /// Index of a node's mesh, which is read once for all nodes that show it with the same morph weights.
    std::uint32_t read_mesh(const Node& node)
    {
        const std::size_t number = document_.index(Document::meshes, node["mesh"]);
        const Node& mesh = document_.all(Document::meshes)[number];
        const std::vector<double> weights = morph_weights(node, mesh);
        const auto [at, is_new] = numbers_.try_emplace({number, weights}, static_cast<std::uint32_t>(meshes_.size()));
        if (is_new) {
            std::vector<GltfPrimitive>& parts = meshes_.emplace_back();
            for (const Node& primitive : list_of(mesh["primitives"])) {
                auto part = GltfPrimitive::read(document_, buffers_, primitive, weights);
                if (!part) continue;
                spend(part->replaced());
                parts.push_back(std::move(*part));
            }
        }
        return at->second;
    }

    void add(std::uint32_t mesh, const Eigen::Affine3d& pose, WeldedMesh& to)
    {
        const bool mirrored = pose.linear().determinant() < 0;
        for (const GltfPrimitive& part : meshes_[mesh]) {
            spend(1 + part.count());
            for (std::size_t i = 0; i < part.count(); ++i) {
                const std::array<std::size_t, 3> vertices = part.triangle(i);
                const std::size_t known = to.weld.size();
                Triangle t;
                for (std::size_t k = 0; k < 3; ++k) t[k] = to.weld.add(pose * part.position(vertices[k]));
                spend(to.weld.size() - known);
                to.add(t, mirrored);
            }
        }
    }

    void spend(std::uint64_t pieces) { expansion_.spend(pieces, buffers_.bytes_read()); }

    GltfDocument document_;
    GltfBuffers buffers_;
    ExpansionLimit expansion_;
    const std::vector<Node>& nodes_;
    std::map<std::pair<std::size_t, std::vector<double>>, std::uint32_t> numbers_; ///< by mesh and morph weights
    std::vector<std::vector<GltfPrimitive>> meshes_;
    NodeTree tree_;
};

} // namespace

RawMesh read_gltf(const MeshSource& source)
{
    return GltfReader(source, ExpansionLimit::any_parts).read();
}

RawAssembly read_gltf_parts(const MeshSource& source, const PartsReading& reading)
{
    return GltfReader(source, reading.most_parts).read_parts(reading.scale, reading.threads);
}

} // namespace oncollide
