#include <oncollide/scenes/files/assembly/placed_meshes.hpp>

#include <fmt/format.h>

namespace oncollide {

namespace {

class Adder {
public:
    Adder(const MeshSource& source, const PlacedMeshes& placed) : source_(source), placed_(placed) {}

    void operator()(std::uint32_t number, const Eigen::Affine3d& pose, WeldedMesh& to) const
    {
        const RawMesh& mesh = placed_.meshes[number];
        std::vector<Eigen::Vector3d> points(mesh.vertices.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            points[i] = pose * mesh.vertices[i];
            if (!points[i].allFinite()) // the welder would compare each such point with all others
                source_.fail(fmt::format("vertex {} of a mesh has no finite position where it is placed", i));
        }
        std::vector<std::uint32_t> numbers(points.size());
        to.weld.add(points, numbers.data());
        const bool mirrored = pose.linear().determinant() < 0;
        for (const Triangle& t : mesh.triangles) to.add({numbers[t[0]], numbers[t[1]], numbers[t[2]]}, mirrored);
    }

private:
    const MeshSource& source_;
    const PlacedMeshes& placed_;
};

} // namespace

RawMesh whole_mesh(const MeshSource& source, const PlacedMeshes& placed, ExpansionLimit& expansion)
{
    const Adder add(source, placed);
    for (const PlacedMeshes::Show& show : placed.shows)
        expansion.spend(placed.pieces(show.mesh)); // spends all before the work begins
    WeldedMesh mesh;
    for (const PlacedMeshes::Show& show : placed.shows) add(show.mesh, show.pose, mesh);
    return mesh.take();
}

RawAssembly parts_of(const MeshSource& source, const PlacedMeshes& placed, ExpansionLimit& expansion,
                     const PartsReading& reading)
{
    PartPlacer placer;
    const auto name_of = [&](std::uint32_t node) -> std::string_view { return placed.names[placed.nodes[node].name]; };
    for (const PlacedMeshes::Show& show : placed.shows) {
        if (placed.meshes[show.mesh].triangles.empty()) continue;
        const std::size_t known = placer.meshes();
        if (!placer.place(show.node, show.mesh, Eigen::Scaling(reading.scale) * show.pose))
            source.fail(fmt::format("{} places its mesh beyond 1e15 m", oncollide::quoted(name_of(show.node))));
        if (placer.meshes() > known) expansion.spend(placed.pieces(show.mesh));
    }
    std::vector<std::uint32_t> above;
    for (const PlacedMeshes::Node& node : placed.nodes) above.push_back(node.above);
    return placer.take(above, name_of, Adder(source, placed), reading.threads);
}

} // namespace oncollide
