#include <cstring>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/files/output_file.hpp>

#include "planted/planted_assembly.hpp"

namespace oncollide::tools {
namespace {

template <class T>
void append(std::string& bytes, const T& value)
{
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void append_floats(std::string& bytes, const Eigen::Vector3d& v)
{
    for (const double x : v) append(bytes, float(x));
}

} // namespace

void write_stl_files(const PlantedAssembly& assembly, const std::filesystem::path& folder)
{
    for (const auto& [name, mesh] : assembly.parts) {
        std::string bytes(80, ' ');
        append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
        for (const Triangle& t : mesh.triangles) {
            append_floats(bytes, Eigen::Vector3d::Zero());
            for (const std::uint32_t corner : t) append_floats(bytes, mesh.vertices[corner]);
            append(bytes, std::uint16_t(0));
        }
        OutputFile file(folder / (name + ".stl"));
        file.write(bytes);
        file.commit();
    }
}

void write_glb_file(const PlantedAssembly& assembly, const std::filesystem::path& path)
{
    using Json = nlohmann::ordered_json;
    Json nodes, meshes, accessors, views;
    nodes.push_back({{"name", "assembly"}, {"scale", {0.001, 0.001, 0.001}}, {"children", Json::array()}});
    std::string data;
    for (std::size_t i = 0; i < assembly.parts.size(); ++i) {
        const auto& [name, mesh] = assembly.parts[i];
        const auto add_view = [&](std::size_t begin) {
            views.push_back({{"buffer", 0}, {"byteOffset", begin}, {"byteLength", data.size() - begin}});
        };
        nodes[0]["children"].push_back(i + 1);
        nodes.push_back({{"name", name}, {"mesh", i}});
        const Json primitive = {{"attributes", {{"POSITION", 2 * i + 1}}}, {"indices", 2 * i}};
        meshes.push_back({{"primitives", Json::array({primitive})}});
        std::size_t begin = data.size();
        for (const Triangle& t : mesh.triangles)
            for (const std::uint32_t corner : t) append(data, corner);
        add_view(begin), begin = data.size();
        for (const Eigen::Vector3d& v : mesh.vertices) append_floats(data, v);
        add_view(begin);
        const auto& [min, max] = mesh.bounds;
        accessors.push_back(
            {{"bufferView", 2 * i}, {"componentType", 5125}, {"count", 3 * mesh.triangles.size()}, {"type", "SCALAR"}});
        accessors.push_back({{"bufferView", 2 * i + 1},
                             {"componentType", 5126},
                             {"count", mesh.vertices.size()},
                             {"type", "VEC3"},
                             {"min", {min.x(), min.y(), min.z()}},
                             {"max", {max.x(), max.y(), max.z()}}});
    }
    std::string json = Json{{"asset", {{"version", "2.0"}}},
                            {"scene", 0},
                            {"scenes", Json::array({{{"nodes", {0}}}})},
                            {"nodes", nodes},
                            {"meshes", meshes},
                            {"accessors", accessors},
                            {"bufferViews", views},
                            {"buffers", Json::array({{{"byteLength", data.size()}}})}}
                           .dump();
    json.append((4 - json.size() % 4) % 4, ' ');
    std::string bytes = "glTF";
    append(bytes, std::uint32_t(2)), append(bytes, static_cast<std::uint32_t>(28 + json.size() + data.size()));
    append(bytes, static_cast<std::uint32_t>(json.size())), bytes += "JSON" + json;
    append(bytes, static_cast<std::uint32_t>(data.size())), bytes.append("BIN\0", 4);
    OutputFile file(path);
    file.write(bytes), file.write(data);
    file.commit();
}

} // namespace oncollide::tools
