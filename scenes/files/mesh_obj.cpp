#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <oncollide/scenes/files/mesh_source.hpp>

namespace oncollide {

namespace {

/// Statements of the OBJ format that say nothing about polygons.
constexpr std::array ignored = {"vt",        "vn",     "vp",     "o",     "g",        "s",        "mg",   "usemtl",
                                "mtllib",    "usemap", "maplib", "l",     "p",        "cstype",   "deg",  "bmat",
                                "step",      "curv",   "curv2",  "surf",  "parm",     "trim",     "hole", "scrv",
                                "sp",        "end",    "con",    "bevel", "c_interp", "d_interp", "lod",  "shadow_obj",
                                "trace_obj", "ctech",  "stech",  "call",  "csh"};

/// The vertex of a corner `7`, `7/1`, `7//2` or `7/1/2`, counted from 0. Negative numbers count back from the last
/// vertex.
std::int64_t corner_vertex(const TextReader& text, std::string_view word, std::size_t vertices)
{
    std::int64_t number = 0;
    if (!parse(word.substr(0, word.find('/')), number))
        text.fail(fmt::format("face corner {} does not begin with a vertex number", quoted(word)));
    const auto count = static_cast<std::int64_t>(vertices);
    if (number == 0) text.fail("face uses vertex 0; vertices are counted from 1, or from -1 backwards");
    if (number < -count)
        text.fail(fmt::format("face uses vertex {}, but there are only {} vertices before it", number, vertices));
    return number > 0 ? number - 1 : count + number;
}

} // namespace

RawMesh read_obj(const MeshSource& source)
{
    RawMesh mesh;
    PolygonList faces;
    TextReader text(source);
    while (text.next_line(true)) {
        const std::string_view keyword = text.word();
        if (keyword == "v") {
            mesh.vertices.push_back(text.point()); // a weight or a colour may follow
        } else if (keyword == "f" || keyword == "fo") {
            faces.begin(text.line());
            int corners = 0;
            for (std::string_view word = text.word(); !word.empty(); word = text.word(), ++corners)
                faces.add(corner_vertex(text, word, mesh.vertices.size()));
            if (corners < 3) text.fail(fmt::format("face has {} corners; it needs at least 3", corners));
        } else if (std::find(ignored.begin(), ignored.end(), keyword) == ignored.end()) {
            text.fail(fmt::format("unknown statement {}; an OBJ file has v, f, vn, vt, g, o, usemtl and the like",
                                  quoted(keyword)));
        }
    }
    mesh.triangles = faces.triangulate(source, mesh.vertices, 1);
    return mesh;
}

} // namespace oncollide
