#include <algorithm>
#include <filesystem>
#include <unordered_map>

#include <oncollide/scenes/files/assembly/raw_assembly.hpp>

namespace oncollide {

namespace {

/// The triangles of a mesh with the vertices that they use.
RawMesh part_of(const MeshSource& source, const RawMesh& whole, std::vector<Triangle> triangles, double scale)
{
    RawMesh part{{}, std::move(triangles)};
    std::unordered_map<std::uint32_t, std::uint32_t> numbers;
    for (Triangle& triangle : part.triangles)
        for (std::uint32_t& v : triangle) {
            if (v >= whole.vertices.size()) source.fail("a triangle uses a vertex that does not exist");
            const auto [at, is_new] = numbers.emplace(v, static_cast<std::uint32_t>(part.vertices.size()));
            if (is_new) part.vertices.push_back(scale * whole.vertices[v]);
            v = at->second;
        }
    return part;
}

} // namespace

RawAssembly read_obj_parts(const MeshSource& source, const PartsReading& reading)
{
    ObjSections all;
    const RawMesh whole = read_obj(source, all);
    std::vector<ObjSections::Section>& sections = all.objects.empty() ? all.groups : all.objects;
    if (sections.empty() || sections.front().begin > 0) sections.insert(sections.begin(), {"", 0});

    std::vector<std::string> names;
    std::vector<std::vector<Triangle>> triangles;
    std::unordered_map<std::string, std::size_t> parts;
    for (std::size_t i = 0; i < sections.size(); ++i) {
        const std::size_t begin = sections[i].begin,
                          end = i + 1 < sections.size() ? sections[i + 1].begin : whole.triangles.size();
        if (begin == end) continue;
        const auto [part, is_new] = parts.emplace(sections[i].name, names.size());
        if (is_new) names.push_back(sections[i].name), triangles.emplace_back();
        triangles[part->second].insert(triangles[part->second].end(), whole.triangles.begin() + std::ptrdiff_t(begin),
                                       whole.triangles.begin() + std::ptrdiff_t(end));
    }
    RawAssembly assembly;
    for (std::uint32_t i = 0; i < names.size(); ++i) {
        const std::string name = names[i].empty() ? path_of(source.name).stem().string() : names[i];
        assembly.meshes.push_back(part_of(source, whole, std::move(triangles[i]), reading.scale));
        assembly.parts.push_back({i, i, Eigen::Isometry3d::Identity(), name, name, no_node});
    }
    return assembly;
}

} // namespace oncollide
