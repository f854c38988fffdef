#include <algorithm>
#include <atomic>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <oncollide/base/parallel.hpp>
#include <oncollide/scenes/files/gltf/gltf_accessor.hpp>
#include <oncollide/scenes/files/gltf/gltf_nodes.hpp>
#include <oncollide/scenes/files/gltf/gltf_parts.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>
#include <oncollide/scenes/files/mesh/welder.hpp>

namespace oncollide {

namespace {

using Document = GltfDocument;

/// Corners of triangles: a part of a mesh. Points and lines are left out.
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
        : source_(source), document_(source), buffers_(document_), meshes_(document_.all(Document::meshes).size())
    {
    }

    RawMesh read()
    {
        Surface whole;
        each_mesh([&](std::uint32_t, const std::vector<Primitive>& parts, const Eigen::Affine3d& pose) {
            for (const Primitive& part : parts) add(part, pose, whole);
        });
        return {whole.weld.take(), std::move(whole.triangles)};
    }

    RawAssembly read_parts(double scale, int threads)
    {
        std::vector<Placed> placed;
        RawAssembly assembly;
        std::vector<std::vector<std::uint32_t>> by_mesh(meshes_.size()); // numbers of `placed`
        each_mesh([&](std::uint32_t node, const std::vector<Primitive>& parts, Eigen::Affine3d pose) {
            if (parts.empty()) return;
            spend(1);
            pose = Eigen::Scaling(scale) * pose;
            const Node& at = document_.all(Document::nodes)[node];
            if (!(pose.matrix().cwiseAbs().maxCoeff() <= 1e15)) at.fail("it places its mesh beyond 1e15 m");
            const std::uint64_t mesh = document_.index(Document::meshes, at["mesh"]);
            const auto [number, rotation] = shared(placed, by_mesh[mesh], parts, pose.linear());
            Eigen::Isometry3d rigid = Eigen::Isometry3d::Identity();
            rigid.linear() = rotation, rigid.translation() = pose.translation();
            assembly.parts.push_back({.node = node, .mesh = number, .pose = rigid});
        });
        name(assembly);
        assembly.meshes.resize(placed.size());
        parallel_chunks(placed.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                Surface surface;
                for (const Primitive& part : *placed[i].parts) add(part, Eigen::Affine3d(placed[i].linear), surface);
                assembly.meshes[i] = {surface.weld.take(), std::move(surface.triangles)};
            }
        });
        return assembly;
    }

private:
    /// Triangles on their way to a mesh.
    struct Surface {
        Welder weld;
        std::vector<Triangle> triangles;
    };
    /// A mesh of the file, turned, stretched or mirrored: what parts that differ only in a rigid pose share.
    struct Placed {
        const std::vector<Primitive>* parts;
        Eigen::Matrix3d linear;
    };

    /// visit(node, parts of its mesh, pose) for each node shown that has a mesh, from the roots down.
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
            if (nodes[i].has("mesh")) visit(i, mesh(nodes[i]["mesh"]), poses[i]);
        }
    }

    /// The number of what a part shares with others of its mesh, and how it is turned. World takes poses that are rigid
    /// to 1e-6; a file's floats are to some 1e-7.
    std::pair<std::uint32_t, Eigen::Matrix3d> shared(std::vector<Placed>& placed, std::vector<std::uint32_t>& of_mesh,
                                                     const std::vector<Primitive>& parts, const Eigen::Matrix3d& linear)
    {
        const Eigen::Matrix3d same = Eigen::Matrix3d::Identity();
        const auto is_rotation = [&](const Eigen::Matrix3d& m) {
            return (m.transpose() * m - same).cwiseAbs().maxCoeff() < 5e-7 && m.determinant() > 0;
        };
        constexpr std::size_t most = 64; // looked at: a file may stretch each part differently
        for (std::size_t k = 0; k < std::min(of_mesh.size(), most); ++k) {
            const Eigen::Matrix3d turned = linear * placed[of_mesh[k]].linear.inverse();
            if (turned.allFinite() && is_rotation(turned))
                return {of_mesh[k], linear == placed[of_mesh[k]].linear ? same : turned};
        }
        const bool rigid = is_rotation(linear);
        of_mesh.push_back(static_cast<std::uint32_t>(placed.size()));
        placed.push_back({&parts, rigid ? same : linear});
        return {of_mesh.back(), rigid ? linear : same};
    }

    /// After their nodes.
    void name(RawAssembly& assembly)
    {
        const std::vector<Node>& nodes = document_.all(Document::nodes);
        const auto name_of = [&](std::uint32_t i) {
            const Node& node = nodes[i];
            if (node.has("name") && node["name"].is_text() && !node["name"].text().empty())
                return std::string(node["name"].text());
            if (node.has("mesh")) {
                const Node& mesh = document_.at(Document::meshes, node["mesh"]);
                if (mesh.has("name") && mesh["name"].is_text() && !mesh["name"].text().empty())
                    return std::string(mesh["name"].text());
            }
            return fmt::format("node {}", i);
        };
        constexpr int levels = 8; // of a path: nodes may be chained by the million
        for (RawPart& part : assembly.parts) {
            part.name = part.path = name_of(part.node);
            part.above = tree_.parents[part.node];
            std::uint32_t above = part.above;
            for (int level = 1; above != no_node && level < levels; ++level, above = tree_.parents[above])
                part.path = name_of(above) + "/" + part.path;
        }
    }

    /// The parts of a mesh: read once, however often it is placed.
    const std::vector<Primitive>& mesh(const Node& number)
    {
        std::optional<std::vector<Primitive>>& parts = meshes_[document_.index(Document::meshes, number)];
        if (parts) return *parts;
        parts.emplace();
        for (const Node& node : list_of(document_.at(Document::meshes, number)["primitives"]))
            if (std::optional<Primitive> part = primitive(node)) parts->push_back(std::move(*part));
        return *parts;
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

    void add(const Primitive& part, const Eigen::Affine3d& pose, Surface& to)
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
            if (mirrored) std::swap(t[1], t[2]); // keeps the front at the front, as the format requires
            to.triangles.push_back(t);
        }
    }

    /// A few bytes may place a mesh a million times, so what they become is bounded: by the bytes of all files, as one
    /// that places everything once needs at least a byte for each triangle and each vertex, or by a number that the
    /// smallest file may grow to.
    void spend(std::uint64_t pieces)
    {
        constexpr std::uint64_t always = 10'000'000, never = 200'000'000;
        if (pieces == 0) return;
        const std::uint64_t spent = spent_ += pieces;
        if (spent <= always) return;
        const std::uint64_t most =
            std::clamp<std::uint64_t>(source_.bytes.size() + buffers_.bytes_read(), always, never);
        if (spent > most)
            source_.fail(fmt::format("its nodes expand to more than {} triangles, vertices and parts of meshes", most));
    }

    const MeshSource& source_;
    GltfDocument document_;
    GltfBuffers buffers_;
    std::vector<std::optional<std::vector<Primitive>>> meshes_;
    NodeTree tree_;
    std::atomic<std::uint64_t> spent_ = 0; ///< by all threads
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
