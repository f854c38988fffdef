#include <oncollide/scenes/files/mesh_source.hpp>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

constexpr std::string_view blank = " \t\r\v\f";

constexpr std::uint32_t empty = 0xffffffffu;

std::size_t hash_of(const Eigen::Vector3d& p)
{
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) // + 0.0: the two zeros are equal
        hash = (hash ^ std::bit_cast<std::uint64_t>(p[axis] + 0.0)) * 0x9E3779B97F4A7C15u, hash ^= hash >> 29;
    return hash;
}

/// Where `point` is among the slots, or the empty one where it belongs.
std::size_t slot_of(const Eigen::Vector3d& point, const std::vector<Eigen::Vector3d>& points,
                    const std::vector<std::uint32_t>& slots)
{
    std::size_t at = hash_of(point) & (slots.size() - 1);
    while (slots[at] != empty && points[slots[at]] != point) at = (at + 1) & (slots.size() - 1);
    return at;
}

} // namespace

void MeshSource::fail(const std::string& what, std::size_t line) const
{
    throw Error(ErrorKind::bad_data,
                line == 0 ? fmt::format("{}: {}", name, what) : fmt::format("{}: line {}: {}", name, line, what));
}

bool TextReader::next_line(bool continued)
{
    joined_.clear();
    while (!rest_.empty()) {
        const std::size_t end = rest_.find('\n');
        std::string_view text = rest_.substr(0, end);
        rest_ = end == rest_.npos ? std::string_view{} : rest_.substr(end + 1);
        ++line_;
        text = text.substr(0, text.find('#'));
        text = text.substr(0, text.find_last_not_of(blank) + 1);
        if (continued && text.ends_with('\\')) {
            joined_.append(text.substr(0, text.size() - 1)).push_back(' ');
            continue;
        }
        if (!joined_.empty()) text = joined_.append(text);
        words_ = text;
        if (text.find_first_not_of(blank) != text.npos) return true;
        joined_.clear();
    }
    words_ = joined_; // the file ended within a continued line
    return words_.find_first_not_of(blank) != words_.npos;
}

std::string_view TextReader::word()
{
    const std::size_t begin = words_.find_first_not_of(blank);
    if (begin == words_.npos) return {};
    const std::size_t end = words_.find_first_of(blank, begin);
    const std::string_view found = words_.substr(begin, end - begin);
    words_ = end == words_.npos ? std::string_view{} : words_.substr(end);
    return found;
}

double TextReader::number(const char* what)
{
    const std::string_view text = word();
    double value = 0;
    if (text.empty()) fail(fmt::format("{} is missing", what));
    if (!parse(text, value) || !std::isfinite(value))
        fail(fmt::format("{} is {}; it must be a finite number", what, quoted(text)));
    return value;
}

std::int64_t TextReader::whole_number(const char* what)
{
    const std::string_view text = word();
    std::int64_t value = 0;
    if (text.empty()) fail(fmt::format("{} is missing", what));
    if (!parse(text, value)) fail(fmt::format("{} is {}; it must be a whole number", what, quoted(text)));
    return value;
}

Eigen::Vector3d TextReader::point()
{
    const double x = number("coordinate x"), y = number("coordinate y"), z = number("coordinate z");
    return {x, y, z};
}

std::string quoted(std::string_view word)
{
    return fmt::format("'{}{}'", printable(word.substr(0, 40)), word.size() > 40 ? "..." : "");
}

bool parse(std::string_view word, double& value)
{
    if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size()) return false;
    if (error == std::errc::result_out_of_range) value = std::strtod(std::string(word).c_str(), nullptr);
    return error != std::errc::invalid_argument;
}

bool parse(std::string_view word, std::int64_t& value)
{
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc{} && end == word.data() + word.size();
}

std::vector<Triangle> PolygonList::triangulate(const MeshSource& source, std::span<const Eigen::Vector3d> vertices,
                                               std::int64_t first) const
{
    std::vector<Triangle> triangles;
    triangles.reserve(faces_.size());
    std::vector<std::uint32_t> polygon;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        const std::size_t end = f + 1 < faces_.size() ? faces_[f + 1].begin : corners_.size();
        polygon.clear();
        for (std::size_t i = faces_[f].begin; i < end; ++i) {
            if (corners_[i] < 0 || corners_[i] >= static_cast<std::int64_t>(vertices.size()))
                source.fail(fmt::format("face uses vertex {}, but the file has {} vertices, counted from {}",
                                        corners_[i] + first, vertices.size(), first),
                            faces_[f].line);
            polygon.push_back(static_cast<std::uint32_t>(corners_[i]));
        }
        if (!oncollide::triangulate(vertices, polygon, triangles))
            source.fail(fmt::format("face has {} corners and is not convex; at most {} corners are allowed then",
                                    polygon.size(), most_concave_corners),
                        faces_[f].line);
    }
    return triangles;
}

std::uint32_t Welder::add(const Eigen::Vector3d& point)
{
    if (2 * (points_.size() + 1) > slots_.size()) grow();
    std::uint32_t& slot = slots_[slot_of(point, points_, slots_)];
    if (slot == empty) {
        slot = static_cast<std::uint32_t>(points_.size());
        points_.push_back(point);
    }
    return slot;
}

void Welder::grow()
{
    slots_.assign(std::max<std::size_t>(64, 2 * slots_.size()), empty);
    for (std::uint32_t i = 0; i < points_.size(); ++i) slots_[slot_of(points_[i], points_, slots_)] = i;
}

void weld(RawMesh& mesh)
{
    Welder weld;
    for (Triangle& t : mesh.triangles)
        for (std::uint32_t& v : t) v = weld.add(mesh.vertices[v]);
    mesh.vertices = weld.take();
}

} // namespace oncollide
