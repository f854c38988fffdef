#include <cstring>

#include <fmt/format.h>

#include <oncollide/base/output_file.hpp>

#include "clash/planted_assembly.hpp"

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
    std::string nodes = R"({"name":"assembly","scale":[0.001,0.001,0.001],"children":[)", meshes, accessors, views,
                data;
    for (std::size_t i = 0; i < assembly.parts.size(); ++i) nodes += fmt::format("{}{}", i ? "," : "", i + 1);
    nodes += "]}";
    for (std::size_t i = 0; i < assembly.parts.size(); ++i) {
        const auto& [name, mesh] = assembly.parts[i];
        const char* comma = i ? "," : "";
        const auto add_view = [&](std::size_t begin) {
            views += fmt::format(R"({}{{"buffer":0,"byteOffset":{},"byteLength":{}}})", views.empty() ? "" : ",", begin,
                                 data.size() - begin);
        };
        nodes += fmt::format(R"(,{{"name":"{}","mesh":{}}})", name, i);
        meshes += fmt::format(R"({}{{"primitives":[{{"attributes":{{"POSITION":{}}},"indices":{}}}]}})", comma,
                              2 * i + 1, 2 * i);
        std::size_t begin = data.size();
        for (const Triangle& t : mesh.triangles)
            for (const std::uint32_t corner : t) append(data, corner);
        add_view(begin), begin = data.size();
        for (const Eigen::Vector3d& v : mesh.vertices) append_floats(data, v);
        add_view(begin);
        const Aabb& b = mesh.bounds;
        accessors += fmt::format(
            R"({}{{"bufferView":{},"componentType":5125,"count":{},"type":"SCALAR"}},)"
            R"({{"bufferView":{},"componentType":5126,"count":{},"type":"VEC3","min":[{},{},{}],"max":[{},{},{}]}})",
            comma, 2 * i, 3 * mesh.triangles.size(), 2 * i + 1, mesh.vertices.size(), b.min.x(), b.min.y(), b.min.z(),
            b.max.x(), b.max.y(), b.max.z());
    }
    std::string json =
        fmt::format(R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{}],"meshes":[{}],)"
                    R"("accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}})",
                    nodes, meshes, accessors, views, data.size());
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
