#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string_view>

namespace oncollide::tools {

/// A style of mesh files: a format, and for OBJ a variant that exporters write.
struct MeshFileStyle {
    std::string_view name, extension;
    std::string_view what; ///< description for the table
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

/// Writes a height field of `cells` x `cells` cells of two triangles, rounded as in the style: random hills from
/// `seed`.
void write_mesh_file(const MeshFileStyle& style, const std::filesystem::path& path, std::uint32_t cells,
                     std::uint64_t seed);

} // namespace oncollide::tools
