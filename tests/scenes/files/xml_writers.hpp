#pragma once
#include "scenes/files/mesh_writers.hpp"

namespace oncollide::test {

// COLLADA and 3MF files.

/// `mesh` as the geometry "g", with the given content of the visual scene.
inline std::string as_dae(const Mesh& mesh, const std::string& nodes = R"(<node><instance_geometry url="#g"/></node>)",
                          const std::string& asset = "<up_axis>Z_UP</up_axis>", const std::string& libraries = "")
{
    std::string positions, corners;
    for (const auto& v : mesh.vertices) positions += fmt::format("{} {} {}\n", v.x(), v.y(), v.z());
    for (const auto& t : mesh.triangles) corners += fmt::format("{} 0 {} 0 {} 0 ", t[0], t[1], t[2]);
    return fmt::format(
        R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>{}</asset>
<library_geometries><geometry id="g" name="thing"><mesh>
<source id="p"><float_array id="pa" count="{}">{}</float_array><technique_common>
<accessor source="#pa" count="{}" stride="3"><param name="X"/><param name="Y"/><param name="Z"/></accessor>
</technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="{}"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#n" offset="1"/>
<p>{}</p></triangles></mesh></geometry></library_geometries>{}
<library_visual_scenes><visual_scene id="s">{}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)",
        asset, 3 * mesh.vertices.size(), positions, mesh.vertices.size(), mesh.triangles.size(), corners, libraries,
        nodes);
}

/// An uncompressed archive of files.
inline std::string as_zip(const std::vector<std::pair<std::string, std::string>>& files)
{
    std::string bytes, directory;
    for (const auto& [name, content] : files) {
        std::uint32_t sum = 0xffffffffu; // CRC-32
        for (const char c : content) {
            sum ^= static_cast<unsigned char>(c);
            for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ (sum & 1 ? 0xedb88320u : 0);
        }
        const auto size = static_cast<std::uint32_t>(content.size());
        std::string header; // the fields that a local header and the directory share
        append(header, std::uint16_t(20)), append(header, std::uint32_t(0)), append(header, std::uint32_t(0x21 << 16));
        append(header, ~sum), append(header, size), append(header, size);
        append(header, static_cast<std::uint16_t>(name.size())), append(header, std::uint16_t(0));
        directory += std::string("PK\1\2\x14\0", 6) + header + std::string(10, '\0');
        append(directory, static_cast<std::uint32_t>(bytes.size())), directory += name;
        bytes += "PK\3\4" + header + name + content;
    }
    const auto at = static_cast<std::uint32_t>(bytes.size());
    bytes += directory + std::string("PK\5\6\0\0\0\0", 8);
    append(bytes, static_cast<std::uint16_t>(files.size())), append(bytes, static_cast<std::uint16_t>(files.size()));
    append(bytes, static_cast<std::uint32_t>(directory.size())), append(bytes, at), append(bytes, std::uint16_t(0));
    return bytes;
}

inline std::string model_xml(const std::string& resources, const std::string& build, const std::string& unit = "meter")
{
    return fmt::format(R"(<?xml version="1.0" encoding="UTF-8"?>
<model unit="{}" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
 xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"><resources>{}</resources><build>{}</build></model>)",
                       unit, resources, build);
}

inline std::string relationships_xml()
{
    return R"(<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">)"
           R"(<Relationship Target="/3D/3dmodel.model" Id="r" Type=")"
           R"(http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)";
}

inline std::string as_3mf(const std::string& model, const std::string& other = "")
{
    return as_zip({{"_rels/.rels", relationships_xml()}, {"3D/3dmodel.model", model}, {"3D/other.model", other}});
}

inline std::string object_xml(const Mesh& mesh, int id, const std::string& attributes = "")
{
    std::string vertices, triangles;
    for (const auto& v : mesh.vertices)
        vertices += fmt::format(R"(<vertex x="{}" y="{}" z="{}"/>)", v.x(), v.y(), v.z());
    for (const auto& t : mesh.triangles)
        triangles += fmt::format(R"(<triangle v1="{}" v2="{}" v3="{}"/>)", t[0], t[1], t[2]);
    return fmt::format(R"(<object id="{}" {}><mesh><vertices>{}</vertices>
<triangles>{}</triangles></mesh></object>)",
                       id, attributes, vertices, triangles);
}

} // namespace oncollide::test
