#pragma once
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>

#include <fmt/format.h>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide::test {

// A mesh as the text or bytes of each file format.

template <class T>
void append(std::string& bytes, T value, bool big_endian = false)
{
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    if (big_endian) std::reverse(raw, raw + sizeof value);
    bytes.append(raw, sizeof value);
}

inline std::string as_obj(const Mesh& mesh)
{
    std::string text = "# made by a test\no thing\n";
    for (const auto& v : mesh.vertices) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
    for (const auto& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    return text;
}

inline std::string as_off(const Mesh& mesh)
{
    std::string text = fmt::format("OFF\n{} {} 0\n", mesh.vertices.size(), mesh.triangles.size());
    for (const auto& v : mesh.vertices) text += fmt::format("{} {} {}\n", v.x(), v.y(), v.z());
    for (const auto& t : mesh.triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    return text;
}

inline std::string ply_header(const Mesh& mesh, const char* format, const char* number)
{
    return fmt::format("ply\nformat {} 1.0\ncomment made by a test\nelement vertex {}\nproperty {} x\nproperty {} y\n"
                       "property {} z\nproperty uchar red\nelement face {}\nproperty list uchar int vertex_indices\n"
                       "end_header\n",
                       format, mesh.vertices.size(), number, number, number, mesh.triangles.size());
}

inline std::string as_text_ply(const Mesh& mesh)
{
    std::string text = ply_header(mesh, "ascii", "double");
    for (const auto& v : mesh.vertices) text += fmt::format("{} {} {} 7\n", v.x(), v.y(), v.z());
    for (const auto& t : mesh.triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    return text;
}

inline std::string as_binary_ply(const Mesh& mesh, bool big_endian)
{
    std::string bytes = ply_header(mesh, big_endian ? "binary_big_endian" : "binary_little_endian", "double");
    for (const auto& v : mesh.vertices) {
        for (int axis = 0; axis < 3; ++axis) append(bytes, v[axis], big_endian);
        bytes += '\7';
    }
    for (const auto& t : mesh.triangles) {
        bytes += '\3';
        for (const std::uint32_t v : t) append(bytes, v, big_endian);
    }
    return bytes;
}

inline std::string as_text_stl(const Mesh& mesh)
{
    std::string text = "solid thing\n";
    for (const auto& t : mesh.triangles) {
        text += "  facet normal 0 0 0\n    outer loop\n";
        for (const std::uint32_t i : t) {
            const auto& v = mesh.vertices[i];
            text += fmt::format("      vertex {} {} {}\n", v.x(), v.y(), v.z());
        }
        text += "    endloop\n  endfacet\n";
    }
    return text + "endsolid thing\n";
}

/// Coordinates are rounded to float.
inline std::string as_binary_stl(const Mesh& mesh)
{
    std::string bytes(80, ' ');
    append(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
        for (int k = 0; k < 3; ++k) append(bytes, 0.0f);
        for (const std::uint32_t i : t)
            for (int axis = 0; axis < 3; ++axis) append(bytes, static_cast<float>(mesh.vertices[i][axis]));
        append(bytes, std::uint16_t(0));
    }
    return bytes;
}

/// The numbers of a glTF file: indices, then positions as floats.
inline std::string gltf_buffer(const Mesh& mesh)
{
    std::string bytes;
    for (const auto& t : mesh.triangles)
        for (const std::uint32_t v : t) append(bytes, v);
    for (const auto& v : mesh.vertices)
        for (int axis = 0; axis < 3; ++axis) append(bytes, static_cast<float>(v[axis]));
    return bytes;
}

/// @param uri   `"uri":"file",` or empty for GLB
/// @param nodes the node array's content; nodes[0] is the root
inline std::string gltf_json(const Mesh& mesh, const std::string& uri, const std::string& nodes = R"({"mesh":0})")
{
    const std::size_t corners = 3 * mesh.triangles.size(), index_bytes = 4 * corners;
    const std::size_t position_bytes = 12 * mesh.vertices.size();
    return fmt::format(
        R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{}],)"
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":1}},"indices":0,"mode":4}}]}}],)"
        R"("accessors":[{{"bufferView":0,"componentType":5125,"count":{},"type":"SCALAR"}},)"
        R"({{"bufferView":1,"componentType":5126,"count":{},"type":"VEC3","min":[{},{},{}],"max":[{},{},{}]}}],)"
        R"("bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],)"
        R"("buffers":[{{{}"byteLength":{}}}]}})",
        nodes, corners, mesh.vertices.size(), mesh.bounds.min.x(), mesh.bounds.min.y(), mesh.bounds.min.z(),
        mesh.bounds.max.x(), mesh.bounds.max.y(), mesh.bounds.max.z(), index_bytes, index_bytes, position_bytes, uri,
        index_bytes + position_bytes);
}

inline std::string as_glb(const Mesh& mesh, const std::string& nodes = R"({"mesh":0})")
{
    std::string json = gltf_json(mesh, "", nodes), buffer = gltf_buffer(mesh), bytes = "glTF";
    while (json.size() % 4 != 0) json += ' ';
    while (buffer.size() % 4 != 0) buffer += '\0';
    append(bytes, std::uint32_t(2)), append(bytes, static_cast<std::uint32_t>(28 + json.size() + buffer.size()));
    append(bytes, static_cast<std::uint32_t>(json.size())), bytes += "JSON" + json;
    append(bytes, static_cast<std::uint32_t>(buffer.size())), bytes += std::string("BIN\0", 4) + buffer;
    return bytes;
}

} // namespace oncollide::test
