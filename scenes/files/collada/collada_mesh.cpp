#include <oncollide/scenes/files/collada/collada_mesh.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <oncollide/scenes/files/mesh/decimal.hpp>
#include <oncollide/scenes/files/mesh/polygon_list.hpp>

namespace oncollide {

namespace {

bool is_space(char c)
{
    return c == ' ' || c == '\n' || c == '\t' || c == '\r';
}

/// Calls visit(word) for each word of the element's text.
template <class Visit>
void each_word(const XmlElement& element, Visit visit)
{
    const char *at = element.text.data(), *const end = at + element.text.size();
    while (true) {
        while (at != end && is_space(*at)) ++at;
        if (at == end) return;
        const char* const begin = at;
        while (at != end && !is_space(*at)) ++at;
        visit(std::string_view(begin, static_cast<std::size_t>(at - begin)));
    }
}

std::vector<std::uint32_t> naturals(const MeshSource& source, const XmlElement& element)
{
    std::vector<std::uint32_t> numbers;
    each_word(element, [&](std::string_view word) {
        std::uint64_t number = 0;
        const char* const end = word.data() + word.size();
        if (word.size() > 10 || read_digits(word.data(), end, number) != end ||
            number >= std::numeric_limits<std::uint32_t>::max())
            source.fail(fmt::format("<{}> holds {}; it must hold whole numbers from 0 on", element.name,
                                    oncollide::quoted(word)),
                        element.line);
        numbers.push_back(static_cast<std::uint32_t>(number));
    });
    return numbers;
}

/// The attribute as an integer; `otherwise` if it is missing.
std::size_t natural(const MeshSource& source, const XmlElement& element, std::string_view attribute,
                    std::size_t otherwise)
{
    const std::string& text = element.attribute(attribute);
    if (text.empty()) return otherwise;
    std::int64_t number = 0;
    if (!parse(text, number) || number < 0)
        source.fail(fmt::format("{} of <{}> is {}; it must be a whole number", attribute, element.name,
                                oncollide::quoted(text)),
                    element.line);
    return static_cast<std::size_t>(number);
}

const XmlElement& child(const MeshSource& source, const XmlElement& element, std::string_view name)
{
    const XmlElement* const found = element.find(name);
    if (!found) source.fail(fmt::format("<{}> has no <{}>", element.name, name), element.line);
    return *found;
}

const XmlElement& input(const MeshSource& source, const XmlElement& element, std::string_view semantic)
{
    for (const XmlElement& one : element.children)
        if (one.name == "input" && one.attribute("semantic") == semantic) return one;
    source.fail(fmt::format("<{}> has no input of the semantic {}", element.name, semantic), element.line);
}

/// Indices of x, y and z in an accessor's parameters: the first three that have a name, since some programs use no
/// names.
std::array<std::size_t, 3> coordinates(const MeshSource& source, const XmlElement& accessor)
{
    std::vector<std::size_t> named, all;
    for (const XmlElement& param : accessor.children) {
        if (param.name != "param") continue;
        if (!param.attribute("name").empty()) named.push_back(all.size());
        all.push_back(all.size());
    }
    const auto& chosen = named.empty() ? all : named;
    if (chosen.size() < 3) source.fail("the accessor of positions has no x, y and z", accessor.line);
    return {chosen[0], chosen[1], chosen[2]};
}

std::vector<Eigen::Vector3d> positions(const MeshSource& source, const XmlElement& of)
{
    const XmlElement& accessor = child(source, child(source, of, "technique_common"), "accessor");
    const XmlElement& array = child(source, of, "float_array");
    if (accessor.attribute("source") != "#" + array.attribute("id"))
        source.fail(fmt::format("the accessor reads {}, which is not the array beside it",
                                oncollide::quoted(accessor.attribute("source"))),
                    accessor.line);
    const std::vector<double> numbers = collada_numbers(source, array);
    if (const std::size_t count = natural(source, array, "count", numbers.size()); count != numbers.size())
        source.fail(fmt::format("<float_array> announces {} numbers, but has {}", count, numbers.size()), array.line);
    const auto [x, y, z] = coordinates(source, accessor);
    const std::size_t count = natural(source, accessor, "count", 0), step = natural(source, accessor, "stride", 1),
                      offset = natural(source, accessor, "offset", 0), last = std::max({x, y, z});
    // Written so that no product overflows.
    const bool fits = last < step && (count == 0 || (offset <= numbers.size() && step <= numbers.size() - offset &&
                                                     count - 1 <= (numbers.size() - offset - step) / step));
    if (!fits)
        source.fail(fmt::format("the accessor announces {} positions of {} numbers from {} on, but there are {}", count,
                                step, offset, numbers.size()),
                    accessor.line);
    std::vector<Eigen::Vector3d> points(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double* const at = numbers.data() + offset + i * step;
        points[i] = {at[x], at[y], at[z]};
    }
    return points;
}

/// The triangles and polygons of one mesh.
class Faces {
public:
    Faces(const MeshSource& source, std::size_t vertices) : source_(source), vertices_(vertices) {}

    /// Adds an element of any name; ignores unknown ones.
    void add(const XmlElement& element)
    {
        const bool triangles = element.name == "triangles", strips = element.name == "tristrips",
                   fans = element.name == "trifans", list = element.name == "polylist";
        if (!triangles && !strips && !fans && !list && element.name != "polygons") return;
        corner_ = natural(source_, input(source_, element, "VERTEX"), "offset", 0);
        step_ = corner_ + 1;
        for (const XmlElement& one : element.children)
            if (one.name == "input") step_ = std::max(step_, natural(source_, one, "offset", 0) + 1);
        if (step_ > 256)
            source_.fail(fmt::format("<{}> has an input of an offset above 255", element.name), element.line);
        std::size_t faces = 0;
        for (const XmlElement& p : element.children) {
            if (p.name == "ph") source_.fail("polygons with holes are not supported; triangulate the mesh", p.line);
            if (p.name != "p") continue;
            const std::vector<std::int64_t> corners = read(p);
            if (triangles)
                faces += add_runs(element, corners, {});
            else if (list)
                faces += add_runs(element, corners, naturals(source_, child(source_, element, "vcount")));
            else
                ++faces, strips || fans ? add_strip(corners, fans) : add_polygon(element, corners);
        }
        if (const std::size_t count = natural(source_, element, "count", faces); count != faces)
            source_.fail(fmt::format("<{}> announces {} faces, but has {}", element.name, count, faces), element.line);
    }

    std::vector<Triangle> take(std::span<const Eigen::Vector3d> points)
    {
        return polygons_.triangulate(source_, points, 0);
    }

private:
    std::vector<std::int64_t> read(const XmlElement& p) const
    {
        const std::vector<std::uint32_t> numbers = naturals(source_, p);
        if (numbers.size() % step_ != 0)
            source_.fail(fmt::format("<p> has {} numbers, but {} make a corner", numbers.size(), step_), p.line);
        std::vector<std::int64_t> corners(numbers.size() / step_);
        for (std::size_t i = 0; i < corners.size(); ++i) {
            corners[i] = numbers[i * step_ + corner_];
            if (corners[i] >= static_cast<std::int64_t>(vertices_))
                source_.fail(fmt::format("<p> uses vertex {}, but there are {} vertices", corners[i], vertices_),
                             p.line);
        }
        return corners;
    }

    /// Adds consecutive faces with these numbers of corners; with three corners each if `counts` is empty.
    std::size_t add_runs(const XmlElement& element, std::span<const std::int64_t> corners,
                         const std::vector<std::uint32_t>& counts)
    {
        const bool triangles = element.name == "triangles";
        std::size_t faces = 0;
        for (; triangles ? corners.size() >= 3 : faces < counts.size(); ++faces) {
            const std::size_t count = triangles ? 3 : counts[faces];
            if (count > corners.size()) source_.fail("<vcount> has more corners than <p>", element.line);
            add_polygon(element, corners.first(count));
            corners = corners.subspan(count);
        }
        if (!corners.empty()) source_.fail(fmt::format("<p> has {} corners too many", corners.size()), element.line);
        return faces;
    }
    void add_polygon(const XmlElement& element, std::span<const std::int64_t> corners)
    {
        if (corners.size() < 3)
            source_.fail(fmt::format("a face of <{}> has {} corners", element.name, corners.size()), element.line);
        polygons_.add(corners, 0);
    }
    void add_strip(std::span<const std::int64_t> corners, bool fan)
    {
        for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
            const std::size_t odd = i % 2;
            const std::array<std::int64_t, 3> face =
                fan ? std::array{corners[0], corners[i + 1], corners[i + 2]}
                    : std::array{corners[i], corners[i + 1 + odd], corners[i + 2 - odd]};
            polygons_.add(face, 0);
        }
    }

    const MeshSource& source_;
    const std::size_t vertices_;
    std::size_t corner_ = 0, step_ = 1; ///< offset of the corners, and stride, in the element being read
    PolygonList polygons_;
};

} // namespace

std::vector<double> collada_numbers(const MeshSource& source, const XmlElement& element)
{
    std::vector<double> numbers;
    each_word(element, [&](std::string_view word) {
        double number = 0;
        if (!parse(word, number) || !std::isfinite(number))
            source.fail(fmt::format("<{}> holds {} at {}; it must hold finite numbers", element.name,
                                    oncollide::quoted(word), numbers.size()),
                        element.line);
        numbers.push_back(number);
    });
    return numbers;
}

void ColladaIds::add(const XmlElement& element)
{
    const std::string& id = element.attribute("id");
    if (!id.empty() && !elements_.emplace(id, &element).second)
        source_.fail(fmt::format("a second <{}> has the id {}", element.name, oncollide::quoted(id)), element.line);
}

const XmlElement* ColladaIds::try_find(std::string_view reference) const
{
    const auto found = reference.starts_with('#') ? elements_.find(reference.substr(1)) : elements_.end();
    return found == elements_.end() ? nullptr : found->second;
}

const XmlElement& ColladaIds::find(const XmlElement& from, std::string_view attribute) const
{
    const std::string_view reference = from.attribute(attribute);
    if (!reference.starts_with('#'))
        source_.fail(fmt::format("{} of <{}> is {}; it must be '#' and an id of this file", attribute, from.name,
                                 oncollide::quoted(reference)),
                     from.line);
    const XmlElement* const found = try_find(reference);
    if (!found)
        source_.fail(fmt::format("<{}> refers to {}, which is no element of that kind in this file", from.name,
                                 oncollide::quoted(reference)),
                     from.line);
    return *found;
}

RawMesh read_collada_mesh(const MeshSource& source, const XmlElement& geometry)
{
    const XmlElement* mesh = geometry.find("mesh");
    if (!mesh) mesh = geometry.find("convex_mesh");
    if (!mesh) return {}; // a spline
    if (!mesh->attribute("convex_hull_of").empty())
        source.fail("<convex_mesh> of another mesh's hull is not supported", mesh->line);
    ColladaIds sources(source);
    for (const XmlElement& element : mesh->children)
        if (element.name == "source") sources.add(element);
    const XmlElement& vertices = child(source, *mesh, "vertices");
    RawMesh raw;
    raw.vertices = positions(source, sources.find(input(source, vertices, "POSITION"), "source"));
    Faces faces(source, raw.vertices.size());
    for (const XmlElement& element : mesh->children) faces.add(element);
    raw.triangles = faces.take(raw.vertices);
    return raw;
}

} // namespace oncollide
