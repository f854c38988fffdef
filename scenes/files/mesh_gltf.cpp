#include <algorithm>
#include <numeric>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <oncollide/scenes/files/gltf/gltf_accessor.hpp>
#include <oncollide/scenes/files/welder.hpp>

namespace oncollide {

namespace {

using Document = GltfDocument;

constexpr std::uint32_t none = 0xffffffffu;

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

Eigen::Affine3d pose_of(const Node& node)
{
    Eigen::Affine3d pose = Eigen::Affine3d::Identity();
    if (node.has("matrix")) {
        const Node matrix = node["matrix"];
        matrix.numbers(16, pose.matrix().data()); // by columns, as Eigen has it
        const Eigen::RowVector4d last = pose.matrix().row(3);
        if (!((last - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() < 1e-6))
            matrix.fail("its last row must be 0, 0, 0, 1");
        pose.makeAffine();
        return pose;
    }
    if (node.has("translation")) pose.translate(node["translation"].vector3());
    if (node.has("rotation")) {
        Eigen::Quaterniond rotation;
        node["rotation"].numbers(4, rotation.coeffs().data()); // x, y, z, w, as Eigen has it
        if (!(rotation.norm() > 1e-6)) node["rotation"].fail("the quaternion has no direction");
        pose.rotate(rotation.normalized());
    }
    if (node.has("scale")) pose.scale(node["scale"].vector3());
    return pose;
}

/// The nodes of a file, from the roots down.
struct NodeTree {
    std::vector<std::uint32_t> parents, order;
    std::vector<bool> shown; ///< by the scene
};

/// Throws unless nodes form trees.
NodeTree node_tree(const Document& document)
{
    const std::vector<Node>& nodes = document.all(Document::nodes);
    NodeTree tree{std::vector<std::uint32_t>(nodes.size(), none), {}, std::vector<bool>(nodes.size(), false)};
    std::vector<std::vector<std::uint32_t>> children(nodes.size());
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
        if (!nodes[i].has("children")) continue;
        for (const Node& number : list_of(nodes[i]["children"])) {
            const auto child = static_cast<std::uint32_t>(document.index(Document::nodes, number));
            if (std::exchange(tree.parents[child], i) != none)
                number.fail(fmt::format("nodes[{}] has two parents; nodes must form a tree", child));
            children[i].push_back(child);
        }
    }
    for (std::uint32_t i = 0; i < nodes.size(); ++i)
        if (tree.parents[i] == none) tree.order.push_back(i);
    const std::size_t roots = tree.order.size();
    for (std::size_t at = 0; at < tree.order.size(); ++at)
        for (const std::uint32_t child : children[tree.order[at]]) tree.order.push_back(child);
    if (tree.order.size() < nodes.size())
        document.source().fail("nodes are their own ancestors; nodes must form a tree");

    if (document.all(Document::scenes).empty()) {
        tree.shown.assign(nodes.size(), true);
        return tree;
    }
    const Node root = document.root();
    const Node& scene =
        root.has("scene") ? document.at(Document::scenes, root["scene"]) : document.all(Document::scenes).front();
    if (scene.has("nodes"))
        for (const Node& number : list_of(scene["nodes"])) {
            const std::size_t i = document.index(Document::nodes, number);
            if (tree.parents[i] != none || tree.shown[i])
                number.fail(fmt::format("nodes[{}] has two parents, the scene and {}", i,
                                        tree.shown[i] ? "the scene" : fmt::format("nodes[{}]", tree.parents[i])));
            tree.shown[i] = true;
        }
    for (std::size_t at = roots; at < tree.order.size(); ++at)
        tree.shown[tree.order[at]] = tree.shown[tree.parents[tree.order[at]]];
    return tree;
}

class GltfReader {
public:
    explicit GltfReader(const MeshSource& source)
        : source_(source), document_(source), buffers_(document_), meshes_(document_.all(Document::meshes).size())
    {
    }

    RawMesh read()
    {
        const std::vector<Node>& nodes = document_.all(Document::nodes);
        const NodeTree tree = node_tree(document_);
        std::vector<Eigen::Affine3d> poses(nodes.size());
        for (const std::uint32_t i : tree.order) {
            if (!tree.shown[i]) continue;
            poses[i] = pose_of(nodes[i]);
            if (tree.parents[i] != none) poses[i] = poses[tree.parents[i]] * poses[i];
            if (!nodes[i].has("mesh")) continue;
            for (const Primitive& part : mesh(nodes[i]["mesh"])) add(part, poses[i]);
        }
        return {weld_.take(), std::move(triangles_)};
    }

private:
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

    void add(const Primitive& part, const Eigen::Affine3d& pose)
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
                const std::size_t known = weld_.size();
                t[k] = weld_.add(pose * part.positions.position(v));
                spend(weld_.size() - known);
            }
            if (mirrored) std::swap(t[1], t[2]); // keeps the front at the front, as the format requires
            triangles_.push_back(t);
        }
    }

    /// A few bytes may place a mesh a million times, so what they become is bounded: by the bytes of all files, as one
    /// that places everything once needs at least a byte for each triangle and each vertex, or by a number that the
    /// smallest file may grow to.
    void spend(std::uint64_t pieces)
    {
        constexpr std::uint64_t always = 10'000'000, never = 200'000'000;
        spent_ += pieces;
        if (spent_ <= always) return;
        const std::uint64_t most =
            std::clamp<std::uint64_t>(source_.bytes.size() + buffers_.bytes_read(), always, never);
        if (spent_ > most)
            source_.fail(fmt::format("its nodes expand to more than {} triangles, vertices and parts of meshes", most));
    }

    const MeshSource& source_;
    GltfDocument document_;
    GltfBuffers buffers_;
    std::vector<std::optional<std::vector<Primitive>>> meshes_;
    Welder weld_;
    std::vector<Triangle> triangles_;
    std::uint64_t spent_ = 0;
};

} // namespace

RawMesh read_gltf(const MeshSource& source)
{
    return GltfReader(source).read();
}

} // namespace oncollide
