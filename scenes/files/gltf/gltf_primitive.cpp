#include <oncollide/scenes/files/gltf/gltf_primitive.hpp>

#include <algorithm>

#include <fmt/format.h>

namespace oncollide {

std::optional<GltfPrimitive> GltfPrimitive::read(const GltfDocument& document, GltfBuffers& buffers, const Node& node,
                                                 std::span<const double> weights)
{
    const std::uint64_t mode = node.has("mode") ? node["mode"].natural() : std::uint64_t(triangles);
    if (mode > fan) node.fail(fmt::format("a primitive has mode {}; modes are 0 to 6", mode));
    if (mode < triangles) return {};
    GltfPrimitive part{node,
                       GltfAccessor::of_positions(document, buffers, node["attributes"]["POSITION"]),
                       {},
                       {},
                       static_cast<Mode>(mode)};
    if (node.has("indices")) part.indices = GltfAccessor::of_corners(document, buffers, node["indices"]);
    const std::size_t corners = part.corners();
    if (mode == triangles ? corners % 3 != 0 : corners < 3)
        node.fail(fmt::format("{} corners make no whole triangles", corners));
    if (!weights.empty()) part.read_moves(document, buffers, weights);
    return part;
}

void GltfPrimitive::read_moves(const GltfDocument& document, GltfBuffers& buffers, std::span<const double> weights)
{
    const Node targets = node["targets"];
    if (targets.size() != weights.size())
        targets.fail(fmt::format("has {} morph targets; there are {} weights", targets.size(), weights.size()));
    const double* weight = weights.data();
    for (const Node& target : targets) {
        const double share = *weight++;
        if (share == 0 || !target.has("POSITION")) continue;
        moves.emplace_back(share, GltfAccessor::of_positions(document, buffers, target["POSITION"]));
        if (const std::size_t moved = moves.back().second.size(); moved != positions.size())
            target.fail(fmt::format("moves {} vertices; the primitive has {}", moved, positions.size()));
    }
}

std::size_t GltfPrimitive::replaced() const
{
    std::size_t sum = positions.replaced() + (indices ? indices->replaced() : 0);
    for (const auto& [weight, target] : moves) sum += target.replaced();
    return sum;
}

std::array<std::size_t, 3> GltfPrimitive::triangle(std::size_t i) const
{
    std::array<std::size_t, 3> corners{3 * i, 3 * i + 1, 3 * i + 2};
    if (mode == fan) corners = {i + 1, i + 2, 0};
    if (mode == strip) corners = {i, i + 1 + i % 2, i + 2 - i % 2};
    for (std::size_t& corner : corners) {
        if (indices) corner = indices->corner(corner);
        if (corner >= positions.size())
            node.fail(
                fmt::format("triangle {} uses vertex {}, but there are {} vertices", i, corner, positions.size()));
    }
    return corners;
}

Eigen::Vector3d GltfPrimitive::position(std::size_t vertex) const
{
    Eigen::Vector3d point = positions.position(vertex);
    for (const auto& [weight, target] : moves) point += weight * target.position(vertex);
    return point;
}

std::vector<double> morph_weights(const Node& node, const Node& mesh)
{
    const Node& owner = node.has("weights") ? node : mesh;
    if (!owner.has("weights")) return {};
    const Node list = owner["weights"];
    std::vector<double> weights(list.size());
    list.numbers(weights.size(), weights.data());
    const bool moves = std::ranges::any_of(weights, [](double weight) { return weight != 0; });
    return moves ? weights : std::vector<double>{};
}

} // namespace oncollide
