#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "model.hpp"

namespace oncollide::cad {
namespace {

using nlohmann::json;

/// Appends a buffer view and an accessor; returns the number of the accessor.
std::size_t add_column(json& file, std::string& bytes, const void* data, std::size_t size, int target, json accessor)
{
    file["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}, {"target", target}});
    accessor["bufferView"] = file["bufferViews"].size() - 1;
    file["accessors"].push_back(std::move(accessor));
    bytes.append(static_cast<const char*>(data), size);
    return file["accessors"].size() - 1;
}

json mesh_json(const Mesh& mesh, const std::string& name, json& file, std::string& bytes)
{
    constexpr float most = std::numeric_limits<float>::max();
    std::array<float, 3> low{most, most, most}, high{-most, -most, -most};
    for (const auto& v : mesh.vertices)
        for (std::size_t k = 0; k < 3; ++k) low[k] = std::min(low[k], v[k]), high[k] = std::max(high[k], v[k]);
    constexpr int floats = 5126, numbers = 5125, vertex_buffer = 34962, index_buffer = 34963;
    const std::size_t position = add_column(
        file, bytes, mesh.vertices.data(), 12 * mesh.vertices.size(), vertex_buffer,
        {{"componentType", floats}, {"count", mesh.vertices.size()}, {"type", "VEC3"}, {"min", low}, {"max", high}});
    const std::size_t indices =
        add_column(file, bytes, mesh.triangles.data(), 12 * mesh.triangles.size(), index_buffer,
                   {{"componentType", numbers}, {"count", 3 * mesh.triangles.size()}, {"type", "SCALAR"}});
    json primitive{{"attributes", {{"POSITION", position}}}, {"indices", indices}};
    if (mesh.colour) {
        json& materials = file["materials"];
        const json material{{"pbrMetallicRoughness", {{"baseColorFactor", *mesh.colour}, {"metallicFactor", 0}}}};
        std::size_t at = 0;
        while (at < materials.size() && materials[at] != material) ++at;
        if (at == materials.size()) materials.push_back(material);
        primitive["material"] = at;
    }
    return {{"name", name}, {"primitives", json::array({primitive})}};
}

json node_json(const Node& node, const Model& model)
{
    json result{{"name", node.name}};
    constexpr std::array<double, 16> identity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    if (node.matrix != identity) result["matrix"] = node.matrix;
    if (!node.children.empty()) result["children"] = node.children;
    if (!node.meshes.empty()) {
        result["mesh"] = node.meshes[0];
        result["extras"] = {{"deflection", node.scale * model.meshes[node.meshes[0]].deflection}};
    }
    return result;
}

std::string word(std::size_t number)
{
    const auto value = std::uint32_t(number);
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &value, 4);
    return bytes;
}

} // namespace

void write_glb(const Model& model, const std::string& name)
{
    json file{{"asset", {{"version", "2.0"}, {"generator", "oncollide-cad"}}}, {"scene", 0}};
    file["scenes"] = json::array({{{"nodes", model.roots}}});
    std::string bytes;
    for (std::size_t i = 0; i < model.meshes.size(); ++i)
        file["meshes"].push_back(mesh_json(model.meshes[i], model.mesh_names[i], file, bytes));
    for (const Node& node : model.nodes) file["nodes"].push_back(node_json(node, model));
    file["buffers"] = json::array({{{"byteLength", bytes.size()}}});
    std::string text = file.dump(-1, ' ', false, json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t size = 12 + 8 + text.size() + 8 + bytes.size();
    if (size > std::size_t(2) << 30)
        throw Fault(bad_data, "its triangles take more than 2 GiB; a coarser --deflection has fewer");
    const std::string head = "glTF" + word(2) + word(size) + word(text.size()) + "JSON";
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(name.c_str(), "wb"),
                                                              [](std::FILE* f) { return f ? std::fclose(f) : 0; });
    bool good = out != nullptr;
    for (const std::string& part : {head, text, word(bytes.size()) + std::string("BIN\0", 4), bytes})
        good = good && std::fwrite(part.data(), 1, part.size(), out.get()) == part.size();
    if (!good || std::fflush(out.get()) != 0) throw Fault(cannot_write, name + ": cannot be written");
}

} // namespace oncollide::cad
