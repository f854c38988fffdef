#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string_view>

namespace oncollide::tools {

/// How mesh files come: each format, and of OBJ what exporters make of it.
struct MeshFileStyle {
    std::string_view name, extension;
    std::string_view what; ///< a few words for the table
};
inline constexpr std::array<MeshFileStyle, 10> mesh_file_styles = {{
    {"obj", "obj", "six decimals, f a b c"},
    {"obj-full", "obj", "vt, vn, f a/b/c, groups, comments, CR LF"},
    {"obj-back", "obj", "negative numbers of vertices, each before its faces"},
    {"obj-exact", "obj", "every digit of a double"},
    {"stl", "stl", "binary"},
    {"stl-mixed", "stl", "binary, triangles in no order"},
    {"ply", "ply", "binary, floats"},
    {"stl-text", "stl", "six decimals"},
    {"ply-text", "ply", "six decimals"},
    {"off", "off", "six decimals"},
}};

/// Writes a height field of `cells` x `cells` cells of two triangles, with rounding as the style has it: hills that are
/// drawn from `seed`.
void write_mesh_file(const MeshFileStyle& style, const std::filesystem::path& path, std::uint32_t cells,
                     std::uint64_t seed);

} // namespace oncollide::tools
