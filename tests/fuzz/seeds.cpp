#include "seeds.hpp"

#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include "scenes/files/mesh_writers.hpp"
#include "scenes/files/xml_writers.hpp"
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/tile_index.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide::test {

namespace {

Mesh box()
{
    return make_box_mesh({1, 2, 3});
}

Mesh soup()
{
    return make_soup_mesh(2, 0.3, 1, 5);
}

/// Rooms of a building, with inner nodes, pruned leaves and free cells.
OccupancyMap map()
{
    return make_building_map(1, 1.0, 3);
}

/// The number of bytes must be a multiple of 3.
std::string base64(const std::string& bytes)
{
    constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i + 2 < bytes.size(); i += 3) {
        unsigned three = 0;
        for (std::size_t k = 0; k < 3; ++k) three = three << 8 | static_cast<unsigned char>(bytes[i + k]);
        for (int shift = 18; shift >= 0; shift -= 6) text += digits[three >> shift & 63];
    }
    return text;
}

std::string map_header(const char* first, std::size_t nodes)
{
    return fmt::format("{}\n# made by a test\nid OcTree\nsize {}\nres 1\ndata\n", first, nodes);
}

} // namespace

std::vector<std::string> obj_seeds()
{
    return {as_obj(box()), as_obj(soup()),
            "mtllib a.mtl\no thing\nv 0 0 0 1\nv 1 0 0 .5 .5 .5\nv 1 1 0\nv 0 1 0\nv .2 .5 0\nvt 0 0\nvn 0 0 1\ns off\n"
            "usemtl red\nf 1/1/1 2//1 3/1 \\\n 4 5\nf -1 -2 -3\nl 1 2\n"};
}

std::vector<std::string> off_seeds()
{
    return {as_off(box()), as_off(soup()),
            "COFF 5 2 0 # colours\n0 0 0 1 1 1 1\n1 0 0\n1 1 0\n0 1 0\n.2 .5 1e-3\n5 0 1 2 3 4 0.5 0.5 0.5\n2 0 1\n"};
}

std::vector<std::string> ply_seeds()
{
    const Mesh mesh = box();
    return {
        as_text_ply(mesh), as_binary_ply(mesh, false), as_binary_ply(mesh, true), as_text_ply(soup()),
        "ply\nformat ascii 1.0\nobj_info x\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "property list uchar short more\nelement edge 1\nproperty int a\nelement face 2\n"
        "property list uchar int vertex_index\nproperty double w\nend_header\n"
        "0 0 0 0\n1 0 0 1 7\n1 1 0 2 7 8\n0 1 0 0\n3\n4 0 1 2 3 0.5\n3 0 2 3 1e300\n"};
}

std::vector<std::string> stl_seeds()
{
    return {as_text_stl(soup()), as_binary_stl(soup()), as_binary_stl(box()),
            "SOLID a\nendsolid a\n" + as_text_stl(soup())};
}

std::vector<std::string> gltf_seeds()
{
    const Mesh mesh = soup();
    std::string shaped = gltf_json(mesh, R"("uri":"buffer.bin",)",
                                   R"({"mesh":0,"skin":0,"children":[1],"extensions":{"EXT_mesh_gpu_instancing":)"
                                   R"({"attributes":{"TRANSLATION":1,"SCALE":1}}}},{"mesh":0,"weights":[2]})");
    const std::string indices = R"("indices":0,"mode":4}])";
    shaped.replace(shaped.find(indices), indices.size(),
                   R"("indices":0,"mode":4,"targets":[{"POSITION":1}]}],"weights":[0.5])");
    return {shaped, gltf_json(mesh, R"("uri":"buffer.bin",)"),
            gltf_json(mesh, R"("uri":"buffer.bin",)",
                      R"({"children":[1,2]},{"mesh":0,"matrix":[1,0,0,0,0,-1,0,0,0,0,1,0,5,6,7,1]},)"
                      R"({"mesh":0,"translation":[1,2,3],"rotation":[0,0,0.6,0.8],"scale":[1,2,-3]})"),
            gltf_json(mesh, R"("uri":"data:application/octet-stream;base64,)" + base64(gltf_buffer(mesh)) + R"(",)")};
}

std::vector<std::string> glb_seeds()
{
    return {as_glb(soup()), as_glb(box(), R"({"children":[1]},{"mesh":0,"translation":[1,2,3]})")};
}

std::vector<std::string> dae_seeds()
{
    const std::string libraries = R"(<library_controllers><controller id="c"><skin source="#g"><bind_shape_matrix>)"
                                  R"(1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix></skin></controller>)"
                                  R"(</library_controllers><library_nodes><node id="n"><scale>1 2 -1</scale>)"
                                  R"(<instance_geometry url="#g"/></node></library_nodes>)";
    const std::string nodes = R"(<node name="a"><lookat>1 2 3 0 0 0 0 0 1</lookat><instance_node url="#n"/></node>)"
                              R"(<node id="b"><rotate>0 0 1 90</rotate><instance_controller url="#c"/></node>)";
    std::string faces = as_dae(box(), R"(<node><instance_geometry url="#g"/></node>)", R"(<unit meter="0.0254"/>)");
    const std::size_t begin = faces.find("<triangles"), end = faces.find("</triangles>") + 12;
    const std::string corner = R"(<input semantic="VERTEX" source="#v" offset="0"/>)";
    faces.replace(begin, end - begin,
                  "<polylist count=\"2\">" + corner + "<vcount>4 3</vcount><p>0 1 3 2 4 5 6</p></polylist>" +
                      "<tristrips count=\"1\">" + corner + "<p>0 1 2 3 4</p></tristrips><trifans count=\"1\">" +
                      corner + "<p>0 1 2 3 4</p></trifans><polygons count=\"1\">" + corner +
                      "<p>0 1 3 2</p></polygons>");
    return {as_dae(box()), as_dae(soup(), nodes, "<up_axis>X_UP</up_axis>", libraries), faces};
}

std::vector<std::string> threemf_seeds()
{
    const std::string resources =
        object_xml(box(), 1, R"(name="a")") + object_xml(soup(), 2) +
        R"(<object id="3"><components><component objectid="1" transform="0 1 0 -1 0 0 0 0 2 5 6 7"/>)"
        R"(<component objectid="2"/></components></object>)";
    const std::string model =
        model_xml(resources, R"(<item objectid="3" transform="1 0 0 0 1 0 0 0 1 9 9 9"/><item objectid="1"/>)", "inch");
    const std::string other = model_xml(object_xml(box(), 4), "", "foot"),
                      both = model_xml(resources, R"(<item objectid="4" p:path="/3D/other.model"/>)");
    return {as_3mf(model), as_3mf(both, other), model, model_xml(object_xml(box(), 1), R"(<item objectid="1"/>)")};
}

std::vector<std::string> bt_seeds()
{
    const TemporaryFolder folder;
    save_octomap(map(), folder / "a.bt");
    octomap::OcTree one(1.0);
    one.updateNode(octomap::point3d(0.5f, 0.5f, 0.5f), true);
    std::ostringstream nodes;
    one.writeBinaryData(nodes);
    return {folder.read("a.bt"), map_header("# Octomap OcTree binary file", one.calcNumNodes()) + nodes.str()};
}

std::vector<std::string> ot_seeds()
{
    std::vector<std::string> seeds;
    octomap::OcTree tree(1.0);
    for (const float x : {0.5f, 1.5f, -7.5f}) {
        tree.updateNode(octomap::point3d(x, 0.5f, 0.5f), x > 0);
        std::ostringstream nodes;
        tree.writeData(nodes);
        seeds.push_back(map_header("# Octomap OcTree file", tree.calcNumNodes()) + nodes.str());
    }
    // Each node has a colour, and lines end with CR LF.
    std::string coloured = "# Octomap OcTree file\r\nid ColorOcTree\r\nsize 17\r\nres 1\r\ndata\r\n";
    for (int level = 0; level <= 16; ++level) coloured += std::string("\0\0\0?rgb", 7) + (level < 16 ? '\1' : '\0');
    seeds.push_back(coloured);
    return seeds;
}

std::vector<std::string> scene_seeds()
{
    return {
        R"({"name": "yard", "frames": 240, "geometries": {
"thing": {"mesh": {"file": "thing.off", "scale": 2, "fit_diagonal": 12, "centre": true}},
"gear": {"mesh": {"generate": {"kind": "gear", "teeth": 5, "root_radius": 0.8, "tip_radius": 1, "thickness": 0.4, "bore_radius": 0.3}}},
"ramp": {"mesh": {"vertices": [[0, 0, 0], [4, 0, 0], [0, 2, 0], [4, 2, 1]], "triangles": [[0, 1, 2], [1, 3, 2]]}},
"ball": {"shape": {"kind": "sphere", "radius": 0.5}}},
"bodies": [{"name": "thing", "geometry": "thing", "static": true},
{"name": "ramp", "geometry": "ramp", "position": [2, 2, 0], "rotation": [0, 0, 0.6, 0.8], "layer": 2, "mask": 3},
{"name": "ball", "geometry": "ball", "motion": {"drift": {"velocity": [0.1, 0.02, 0], "spin": [0, 0, 0.05], "walls": [[0, 0, 0], [9, 9, 3]]}}},
{"name": "ball 2", "geometry": "ball", "motion": {"jitter": {"step": 0.1, "seed": 42, "index": 1, "walls": [[0, 0, 0], [9, 9, 3]]}}},
{"name": "walker", "geometry": "ball", "motion": {"tum": {"file": "walk.tum", "frames_per_second": 30}}},
{"name": "gear", "geometry": "gear", "motion": {"keys": [[0, 5, 0, 1, 0, 0, 0, 1], [120, 5, 4, 1, 0, 0, 1, 0]]}}]}
)",
        R"({"frames": 3, "geometries": {
"recorded": {"mesh": {"vertices": [[0, 0, 0], [4, 0, 0], [0, 2, 0], [4, 2, 1]], "triangles": [[0, 1, 2]]}, "deformation": {"file": "vertices.npy"}},
"flag": {"mesh": {"generate": {"kind": "sheet", "size": [2, 1], "cells": [3, 2]}}, "deformation": {"flutter":
{"edge": [-1, 0, 0], "along": [1, 0, 0], "normal": [0, 0, 1], "growth": 0.4, "waves": [[0.8, 1.5, 20, 0.1, 0], [0.3, 0.5, 9, 0, 0.5]]}}}},
"bodies": [{"geometry": "recorded"}, {"geometry": "flag"}]}
)",
        R"({"geometries": {
"a": {"mesh": {"generate": {"kind": "box", "half": [1, 2, 3]}}},
"b": {"mesh": {"generate": {"kind": "sphere", "radius": 1, "triangles": 32}}},
"c": {"mesh": {"generate": {"kind": "torus", "major": 2, "minor": 1, "triangles": 20}}},
"d": {"mesh": {"generate": {"kind": "torus_knot", "p": 2, "q": 3, "major": 1, "minor": 0.4, "tube": 0.15, "triangles": 60}}},
"e": {"mesh": {"generate": {"kind": "terrain", "size": 4, "height": 1, "cells": 2, "seed": 3}}},
"f": {"mesh": {"generate": {"kind": "needles", "count": 3, "length": 1, "aspect": 1e5, "size": 3}}},
"g": {"mesh": {"generate": {"kind": "soup", "count": 3, "edge": 1, "size": 3}}}}, "bodies": []}
)",
        R"({"geometries": {
"a": {"shape": {"kind": "box", "half": [1, 2, 3]}},
"b": {"shape": {"kind": "capsule", "radius": 1, "length": 2}},
"c": {"shape": {"kind": "cylinder", "radius": 1, "length": 2}},
"d": {"shape": {"kind": "convex_hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}},
"e": {"octomap": {"building": {"rooms": 1, "resolution": 1, "seed": 7}}},
"f": {"octomap": {"file": "map.bt"}},
"g": {"terrain": {"file": "land.pgm", "spacing": [2, 3], "vertical_scale": 0.1, "no_data": 97, "bytes": 2, "centre": true}},
"h": {"terrain": {"hills": {"cells": [3, 2], "spacing": 1, "height": 2}}}},
"bodies": [{"name": "a", "geometry": "a", "rotation": [[1, 0, 0], [0, 0, -1], [0, 1, 0]]}]}
)",
        R"({"exclude": [["a", 1], [2, "a"]], "bodies": [{"name": "a", "geometry": "b", "group": 3},
{"geometry": "b", "group": 3}, {"geometry": "b"}], "geometries": {"b": {"shape": {"kind": "sphere", "radius": 1}}}}
)"};
}

std::vector<std::string> pgm_seeds()
{
    return {"P5 3 2 255\nabcdef", "P5\n# heights\n2 2\n65535\nabcdefgh"};
}

/// Three by two heights of 16 bits, two by two of 8; then interlaced.
std::vector<std::string> png_seeds()
{
    std::vector<std::string> seeds;
    for (const std::string_view hex :
         {"89504e470d0a1a0a0000000d4948445200000003000000021000000000e88fe5850000001649444154789c636060606064606260d461"
          "6061600500011b003a16a31ee20000000049454e44ae426082",
          "89504e470d0a1a0a0000000d494844520000000200000002080000000057dd52f80000000e49444154789c6360606460fa0f00010d01"
          "03d67c8ba80000000049454e44ae426082",
          "89504e470d0a1a0a0000000d49484452000000030000000210000000019f88d513000000164944415478da636000022606064606461d"
          "06160656000121003aacef30d00000000049454e44ae426082"}) {
        std::string& bytes = seeds.emplace_back();
        for (std::size_t i = 0; i < hex.size(); i += 2)
            bytes += static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16));
    }
    return seeds;
}

std::vector<std::string> npy_seeds()
{
    const auto array = [](std::string_view type, std::string_view order, std::size_t bytes) {
        const std::string header =
            fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': (3, 2), }}\n", type, order);
        return std::string("\x93NUMPY\x01\0", 8) + static_cast<char>(header.size()) + '\0' + header +
               std::string(6 * bytes, '\2');
    };
    return {array("<i2", "False", 2), array(">f4", "True", 4), array("|u1", "False", 1)};
}

std::vector<std::string> poses_seeds()
{
    return {"0 0x1p-3 1 0 0 0 1 0 0 0 1 0.5 -2 3e-1\n", "1 -0.25 0 -1 0 1 0 0 0 0 1 0 0 0x1.8p+1\n"};
}

std::vector<std::string> aabbs_seeds()
{
    std::string bytes = "scene";
    bytes.resize(128);
    bytes += "cubes";
    bytes.resize(256);
    for (const std::int32_t v : {2, 1, 0, 0}) append(bytes, v);
    for (const float v : {-9, -9, -9, 0, 9, 9, 9, 0}) append(bytes, v);
    for (const float x : {0, 3, 1, 4})
        for (const float v : {x, 0.f, 0.f, 0.f, x + 1, 1.f, 1.f, 0.f}) append(bytes, v);
    return {bytes};
}

std::vector<std::string> table_seeds()
{
    return {"name,geometry,x,y,z,qx,qy,qz,qw,vx,vy,vz,layer,mask,group,static\r\n"
            "a,ball,0.1,-2,3e2,0,0,0.6,0.8,0.5,0,0,2,3,4,0\r\n,\"b, c\",1,2,3,0,0,0,1,0,0,0,1,4294967295,0,1\r\n",
            "geometry,x,y,z\nball,1,2,3\nball,4,5,6\n"};
}

namespace {

std::string npy_of(const char* shape, int count, auto number, auto number_of)
{
    std::string header =
        fmt::format("{{'descr': '<f{}', 'fortran_order': False, 'shape': {}, }}", sizeof number, shape);
    header.resize(117, ' '), header += '\n';
    std::string bytes = std::string("\x93NUMPY\x01\0", 8) + char(header.size()) + '\0' + header;
    for (int i = 0; i < count; ++i) number = number_of(i), append(bytes, number);
    return bytes;
}

} // namespace

/// Two frames of one body, three of two.
std::vector<std::string> recording_seeds()
{
    const auto number = [](int i) { return i % 7 < 3 ? 0.5f : float(i % 7 == 6); };
    return {npy_of("(2, 1, 7)", 14, 0.0, number), npy_of("(3, 2, 7)", 42, 0.0f, number)};
}

/// Two and three frames of four vertices.
std::vector<std::string> vertices_seeds()
{
    const auto number = [](int i) { return 0.25f * float(i % 13); };
    return {npy_of("(2, 4, 3)", 24, 0.0, number), npy_of("(3, 4, 3)", 36, 0.0f, number)};
}

/// Meshes of one chunk, and of several under up to three levels of nodes; floats and doubles; with vertices that no
/// triangle uses; in parts; closed and not. Terrains and maps.
std::vector<std::string> cooked_seeds()
{
    const TemporaryFolder folder;
    std::vector<std::string> seeds;
    const auto add = [&](const Mesh& mesh, std::uint32_t chunk) {
        cook_mesh(mesh, folder / "a.cooked", chunk);
        seeds.push_back(folder.read("a.cooked"));
    };
    add(box(), 8192), add(make_soup_mesh(9, 0.8, 2, 5), 8192);
    add(make_soup_mesh(11, 0.8, 2, 6), 3), add(make_sphere_mesh(1, 20), 4), add(make_sphere_mesh(1, 44), 4);
    const Mesh ground = make_terrain_mesh(2, 0.5, 4, 2);
    std::vector<Eigen::Vector3d> vertices = ground.vertices;
    for (Eigen::Vector3d& v : vertices) v = v.cast<float>().cast<double>();
    vertices.insert(vertices.begin() + 3, {0, 0, 0.25});
    std::vector<Triangle> triangles = ground.triangles;
    for (Triangle& t : triangles)
        for (std::uint32_t& corner : t) corner += corner >= 3;
    add(make_mesh("ground", std::move(vertices), std::move(triangles)), 4);

    // Heights at 1, 2 and 8 bytes, in four chunks and in one; with holes; with a diagonal per cell.
    const auto add_heights = [&](TerrainGrid grid, double holes) {
        std::vector<double> heights;
        for (std::uint32_t i = 0; i < grid.columns * grid.rows; ++i)
            heights.push_back(u01(3, i, 0) < holes ? std::nan("") : std::round(64 * u01(2, i, 0)) / 64);
        if (holes > 0) grid.no_data = std::nan("");
        grid.origin = {-1, -1, 0}, grid.spacing = {3.0 / grid.columns, 3.0 / grid.rows};
        cook_terrain(make_terrain("heights", grid, heights), folder / "a.cooked");
        seeds.push_back(folder.read("a.cooked"));
    };
    add_heights({.columns = 65, .rows = 9}, 0), add_heights({.columns = 9, .rows = 8, .bytes = 8, .error = 0.01}, 0);
    TerrainGrid mixed{.columns = 10, .rows = 9, .bytes = 2};
    for (std::uint64_t i = 0; i < 72; ++i) mixed.falling.push_back(u01(4, i, 0) < 0.5);
    add_heights(mixed, 0.1);

    // Maps of one chunk, with unknown cells that count as occupied, and of several chunks.
    const auto add_map = [&](const OccupancyMap& of, std::uint32_t chunk) {
        cook_map(of, folder / "a.cooked", chunk);
        seeds.push_back(folder.read("a.cooked"));
    };
    CellTree cells(true), blocks;
    for (std::int32_t i = 0; i < 12; ++i) {
        const Eigen::Vector3i at(i * 3 % 8 - 3, i * 5 % 7 - 2, i * 11 % 13);
        cells.set({at, at.array() + 1 + i % 2}, i % 3 ? CellState::occupied : CellState::free);
        blocks.set({at, at.array() + 1 + i % 3}, CellState::occupied);
    }
    add_map(MapAccess::make("unknown", std::move(cells), 0.25), 4096),
        add_map(MapAccess::make("blocks", std::move(blocks), 0.25), 6);
    return seeds;
}
std::vector<std::string> tiles_seeds()
{
    const TemporaryFolder folder;
    std::vector<std::string> seeds;
    for (const char* file : {"tile.cooked", "none.cooked"}) {
        cook_mesh(box(), folder / "tile.cooked");
        IndexedTile tile = index_tile(folder.path(), "tile.cooked");
        tile.file = file;
        save_tile_index(folder / "tiles.json", {tile});
        seeds.push_back(folder.read("tiles.json"));
    }
    return seeds;
}

void add_companions(const TemporaryFolder& folder)
{
    folder.write("arm.urdf", urdf_seeds().front());
    folder.write("part.xml", "<mujocoinclude><worldbody><geom size='1'/></worldbody></mujocoinclude>");
    folder.write("good-scene.yaml", problem_seeds().front());
    folder.write("good-request.yaml", request_seeds().front());
    folder.write("wedge.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    cook_mesh(box(), folder / "tile.cooked");
    folder.write("buffer.bin", gltf_buffer(soup()));
    folder.write("thing.off", as_off(box()));
    folder.write("walk.tum", "0 1 2 3 0 0 0 1\n0.5 1 2 4 0 0 0.6 0.8\n");
    folder.write("land.pgm", pgm_seeds()[0]);
    folder.write("vertices.npy", vertices_seeds()[0]);
    folder.write("deforming.json", R"({"geometries": {"cloth": {"mesh": {"vertices": [[0, 0, 0], [4, 0, 0], [0, 2, 0],
        [4, 2, 1]], "triangles": [[0, 1, 2]]}, "deformation": {"file": "moved.npy"}}}, "bodies": [{"geometry": "cloth"}]})");
    folder.write("expected", "0 1 7\n");
    const std::string geometries = R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}},
        "b, c": {"shape": {"kind": "box", "half": [1, 1, 1]}}}, )";
    folder.write("table.json", geometries + R"("tables": [{"file": "input.csv"}]})");
    folder.write("recorded.json", geometries + R"("bodies": [{"geometry": "ball"}, {"geometry": "ball"}],
        "recording": {"file": "recorded.npy"}})");
    folder.write("hdf5-table.json", geometries + R"("tables": [{"file": "input.h5"}]})");
    folder.write("hdf5-recording.json", geometries + R"("bodies": [{"geometry": "ball"}, {"geometry": "ball"}],
        "recording": {"file": "input.h5"}})");
    save_octomap(map(), folder / "map.bt");
}

} // namespace oncollide::test
