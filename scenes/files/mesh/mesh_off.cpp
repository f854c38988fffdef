#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <oncollide/scenes/files/mesh/polygon_list.hpp>

namespace oncollide {

namespace {

/// Kinds of text OFF whose vertex lines begin with x y z, followed by a normal, a colour or a texture coordinate.
constexpr std::array headers = {"OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF", "STCNOFF"};

std::int64_t count(TextReader& text, const char* what, std::size_t bytes)
{
    const std::int64_t value = text.whole_number(what);
    if (value < 0 || static_cast<std::uint64_t>(value) > bytes)
        text.fail(fmt::format("{} is {}, which a file of {} bytes cannot hold", what, value, bytes));
    return value;
}

void need_line(TextReader& text, const char* what, std::int64_t got, std::int64_t want)
{
    if (!text.next_line()) text.fail(fmt::format("the file ends after {} of {} {}", got, want, what));
}

} // namespace

RawMesh read_off(const MeshSource& source)
{
    TextReader text(source);
    if (!text.next_line()) source.fail("the file has no content");
    const std::string_view header = text.word();
    if (std::find(headers.begin(), headers.end(), header) == headers.end())
        // Another variant of the format, such as 4OFF, is named; text of another kind of file is not quoted.
        text.fail(header.size() <= 8 && header.ends_with("OFF")
                      ? fmt::format("the file begins with {}, not with OFF (or COFF, NOFF, STOFF)", quoted(header))
                      : "the file does not begin with OFF (or COFF, NOFF, STOFF)");
    std::string_view first = text.word();
    if (first == "BINARY") text.fail("binary OFF is not supported; text OFF is");
    std::int64_t vertices = 0;
    if (first.empty()) {
        need_line(text, "lines of counts", 0, 1);
        vertices = count(text, "the number of vertices", source.bytes.size());
    } else if (!parse(first, vertices) || vertices < 0 || static_cast<std::uint64_t>(vertices) > source.bytes.size()) {
        text.fail(fmt::format("the number of vertices is {}", quoted(first)));
    }
    const std::int64_t polygons = count(text, "the number of faces", source.bytes.size());

    RawMesh mesh;
    for (std::int64_t i = 0; i < vertices; ++i) {
        need_line(text, "vertices", i, vertices);
        mesh.vertices.push_back(text.point());
    }
    PolygonList faces;
    std::vector<std::int64_t> corners;
    for (std::int64_t i = 0; i < polygons; ++i) {
        need_line(text, "faces", i, polygons);
        const std::int64_t count = text.whole_number("the number of corners");
        if (count < 1) text.fail(fmt::format("face has {} corners", count));
        if (count < 3) continue; // a point or a line
        corners.clear();
        for (std::int64_t k = 0; k < count; ++k) corners.push_back(text.whole_number("a vertex number of the face"));
        faces.add(corners, text.line());
    }
    if (text.next_line()) text.fail(fmt::format("more lines than the {} faces that the header announces", polygons));
    mesh.triangles = faces.triangulate(source, mesh.vertices, 0);
    return mesh;
}

} // namespace oncollide
