#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/scenes/files/mesh/decimal.hpp>
#include <oncollide/scenes/files/mesh/polygon_list.hpp>

namespace oncollide {

namespace {

/// OBJ statements that do not affect polygons.
constexpr std::array ignored = {"vt",     "vn",         "vp",        "s",     "mg",     "usemtl",   "mtllib",
                                "usemap", "maplib",     "l",         "p",     "cstype", "deg",      "bmat",
                                "step",   "curv",       "curv2",     "surf",  "parm",   "trim",     "hole",
                                "scrv",   "sp",         "end",       "con",   "bevel",  "c_interp", "d_interp",
                                "lod",    "shadow_obj", "trace_obj", "ctech", "stech",  "call",     "csh"};

struct Counts {
    std::size_t vertices = 0, faces = 0;
};

Counts count_lines(std::string_view text)
{
    Counts counts;
    for (std::size_t at = text.find('\n'); at != text.npos && at + 2 < text.size(); at = text.find('\n', at + 1)) {
        if (!is_blank(text[at + 2])) continue;
        counts.vertices += text[at + 1] == 'v', counts.faces += text[at + 1] == 'f';
    }
    return counts;
}

/// Estimates the counts of a large file, slightly too high, from a small sample of its lines. No line is shorter than
/// eight bytes.
Counts estimate(std::string_view bytes)
{
    constexpr std::size_t looks = 256, window = 4096;
    if (bytes.size() < 4 * looks * window) return {};
    Counts seen;
    for (std::size_t i = 0; i < looks; ++i) {
        const Counts here = count_lines(bytes.substr(bytes.size() / looks * i, window));
        seen.vertices += here.vertices, seen.faces += here.faces;
    }
    const auto of_all = [&](std::size_t count) {
        return std::min(bytes.size() / 8, bytes.size() / (looks * window) * (count + count / 16 + 64));
    };
    return {of_all(seen.vertices), of_all(seen.faces)};
}

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

/// Reads the plain lines that make up nearly all of a file in one pass each: `v` and three decimals, `f` and three
/// corners, texture coordinates, normals, comments. Stops before the first line of another kind.
class PlainLines {
public:
    PlainLines(const MeshSource& source, RawMesh& mesh, PolygonList& faces)
        : end_(source.bytes.data() + source.bytes.rfind('\n') + 1), mesh_(mesh), faces_(faces)
    {
    }

    void read(TextReader& text)
    {
        const char* const begin = text.rest().data();
        const char* line = begin;
        std::size_t lines = 0;
        while (!text.rest().empty() && line < end_) {
            const char* const next = read_line(line, text.line() + lines + 1);
            if (!next) break;
            line = next, ++lines;
            text.reached(line);
        }
        text.skip_lines(static_cast<std::size_t>(line - begin), lines);
    }

private:
    /// The start of the next line; null: this line is not plain.
    const char* read_line(const char* at, std::size_t line)
    {
        if (*at == 'v') return is_blank(at[1]) ? read_vertex(at + 2) : read_ignored(at);
        if (*at == 'f' && is_blank(at[1])) return read_face(at + 2, line);
        return *at == '#' || is_blank(*at) || *at == '\n' ? read_comment(at) : nullptr;
    }
    static const char* skip_blanks(const char* at)
    {
        while (is_blank(*at)) ++at;
        return at;
    }
    /// Null if the line continues on the next one.
    const char* end_of_line(const char* at) const
    {
        at = skip_blanks(at);
        if (*at == '\n') return at + 1;
        const char* const last = static_cast<const char*>(std::memchr(at, '\n', static_cast<std::size_t>(end_ - at)));
        return std::memchr(at, '\\', static_cast<std::size_t>(last - at)) ? nullptr : last + 1;
    }
    const char* read_comment(const char* at) const
    {
        at = skip_blanks(at);
        return *at == '#' || *at == '\n' ? end_of_line(at) : nullptr;
    }
    const char* read_ignored(const char* at) const
    {
        return (at[1] == 't' || at[1] == 'n') && is_blank(at[2]) ? end_of_line(at + 3) : nullptr;
    }
    const char* read_vertex(const char* at)
    {
        Eigen::Vector3d point;
        for (int axis = 0; axis < 3; ++axis) {
            at = skip_blanks(at);
            const char* const behind = read_decimal(at, end_, point[axis]);
            at = behind ? behind : read_number(at, point[axis]);
            if (!at || !ends_word(*at)) return nullptr;
        }
        at = end_of_line(at); // ignores a weight or a colour
        if (at) append_large(mesh_.vertices, point);
        return at;
    }
    const char* read_number(const char* at, double& value) const
    {
        const auto [behind, error] = std::from_chars(at, end_, value);
        return error == std::errc{} && std::isfinite(value) ? behind : nullptr;
    }
    const char* read_face(const char* at, std::size_t line)
    {
        std::array<std::int64_t, 8> corners;
        std::size_t count = 0;
        for (at = skip_blanks(at); *at != '\n'; at = skip_blanks(at)) {
            if (count == corners.size() || !(at = read_corner(at, corners[count++]))) return nullptr;
        }
        if (count < 3) return nullptr;
        faces_.add({corners.data(), count}, line);
        return at + 1;
    }
    const char* read_corner(const char* at, std::int64_t& corner) const
    {
        const bool backward = *at == '-';
        const char* const begin = at += backward;
        std::uint64_t number = 0;
        at = read_digits(at, end_, number);
        if (at - begin > 18 || number == 0 || (backward && number > mesh_.vertices.size())) return nullptr;
        corner = static_cast<std::int64_t>(backward ? mesh_.vertices.size() - number : number - 1);
        if (*at == '/') at = skip_word(at);
        return ends_word(*at) ? at : nullptr;
    }
    static bool ends_word(char c) { return is_blank(c) || c == '\n'; }
    /// Skips a number of texture coordinates and normals.
    static const char* skip_word(const char* at)
    {
        while (is_digit(*at) || *at == '/' || *at == '-') ++at;
        return at;
    }

    const char* end_; ///< the end of the last complete line, so every line that is read has an end
    RawMesh& mesh_;
    PolygonList& faces_;
};

/// The rest of the line, with single blanks.
std::string name_in(TextReader& text)
{
    std::string name;
    for (std::string_view word = text.word(); !word.empty(); word = text.word()) {
        if (!name.empty()) name += ' ';
        name += word;
    }
    return name;
}

/// Replaces a section without triangles, so that no file has more sections than triangles.
void begin_section(std::vector<ObjSections::Section>& sections, ObjSections::Section section)
{
    if (!sections.empty() && sections.back().begin == section.begin) sections.pop_back();
    sections.push_back(std::move(section));
}

} // namespace

RawMesh read_obj(const MeshSource& source, ObjSections& sections)
{
    RawMesh mesh;
    PolygonList faces;
    const Counts expected = estimate(source.bytes);
    reserve_large(mesh.vertices, expected.vertices);
    faces.reserve(expected.faces);
    PlainLines plain(source, mesh, faces);
    std::vector<std::int64_t> corners;
    TextReader text(source);
    for (plain.read(text); text.next_line(true); plain.read(text)) {
        const std::string_view keyword = text.word();
        if (keyword == "v") {
            mesh.vertices.push_back(text.point()); // ignores a weight or a colour
        } else if (keyword == "f" || keyword == "fo") {
            corners.clear();
            for (std::string_view word = text.word(); !word.empty(); word = text.word())
                corners.push_back(corner_vertex(text, word, mesh.vertices.size()));
            if (corners.size() < 3) text.fail(fmt::format("face has {} corners; it needs at least 3", corners.size()));
            faces.add(corners, text.line());
        } else if (keyword == "o" || keyword == "g") {
            begin_section(keyword == "o" ? sections.objects : sections.groups, {name_in(text), faces.triangle_count()});
        } else if (std::find(ignored.begin(), ignored.end(), keyword) == ignored.end()) {
            // Text of another kind of file is not quoted, because a link may lead to any file.
            const bool is_obj = !mesh.vertices.empty() || !sections.objects.empty() || !sections.groups.empty();
            text.fail(fmt::format("{}; an OBJ file has v, f, vn, vt, g, o, usemtl and the like",
                                  is_obj ? fmt::format("unknown statement {}", quoted(keyword)) : "not an OBJ file"));
        }
    }
    mesh.triangles = faces.triangulate(source, mesh.vertices, 1);
    return mesh;
}

RawMesh read_obj(const MeshSource& source)
{
    ObjSections sections;
    return read_obj(source, sections);
}

} // namespace oncollide
