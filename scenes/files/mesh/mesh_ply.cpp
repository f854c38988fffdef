#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/scenes/files/mesh/ply_header.hpp>
#include <oncollide/scenes/files/mesh/polygon_list.hpp>

namespace oncollide {

namespace {

static_assert(std::endian::native == std::endian::little);

using namespace ply;

constexpr std::array<std::size_t, 8> type_bytes = {1, 1, 2, 2, 4, 4, 4, 8};

/// Reads the values after the header in sequence.
class Values {
public:
    Values(const MeshSource& source, const Header& header)
        : source_(source), encoding_(header.encoding), rest_(source.bytes.substr(header.bytes)), line_(header.lines + 1)
    {
    }

    /// A double can represent every type of PLY without rounding.
    double next(Type type) { return encoding_ == Encoding::text ? next_word() : next_bytes(type); }
    std::int64_t next_whole(Type type, const char* what)
    {
        const double value = next(type);
        if (value != std::floor(value) || !(std::abs(value) < 0x1p53))
            fail(fmt::format("{} is {}; it must be a whole number", what, value));
        return static_cast<std::int64_t>(value);
    }
    void check_end()
    {
        if (encoding_ == Encoding::text) skip_blank();
        if (!rest_.empty())
            fail(fmt::format("{} bytes follow after the last element that the header announces", rest_.size()));
    }
    void within(const char* element, std::int64_t row, std::int64_t rows)
    {
        element_ = element, row_ = row, rows_ = rows;
    }
    [[noreturn]] void fail(const std::string& what) const
    {
        source_.fail(what, encoding_ == Encoding::text ? line_ : 0);
    }
    std::size_t line() const { return encoding_ == Encoding::text ? line_ : 0; }

    /// The bytes that have the layout of memory; take() consumes some.
    std::string_view plain() const { return encoding_ == Encoding::little_endian ? rest_ : std::string_view{}; }
    void take(std::size_t bytes) { rest_.remove_prefix(bytes); }

private:
    void skip_blank()
    {
        while (!rest_.empty() && std::isspace(static_cast<unsigned char>(rest_.front()))) {
            line_ += rest_.front() == '\n';
            rest_.remove_prefix(1);
        }
    }
    [[noreturn]] void fail_short() const
    {
        fail(fmt::format("the file ends within {} {} of {}", element_, row_, rows_));
    }
    double next_word()
    {
        skip_blank();
        const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t\r\n\v\f"));
        rest_.remove_prefix(word.size());
        double value = 0;
        if (word.empty()) fail_short();
        if (!parse(word, value)) fail(fmt::format("{} is not a number", quoted(word)));
        return value;
    }
    double next_bytes(Type type)
    {
        const std::size_t size = type_bytes[static_cast<std::size_t>(type)];
        if (rest_.size() < size) fail_short();
        std::array<char, 8> raw{};
        std::copy_n(rest_.begin(), size, raw.begin());
        rest_.remove_prefix(size);
        if (encoding_ == Encoding::big_endian)
            std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
        switch (type) {
        case Type::int8:
            return as<std::int8_t>(raw);
        case Type::uint8:
            return as<std::uint8_t>(raw);
        case Type::int16:
            return as<std::int16_t>(raw);
        case Type::uint16:
            return as<std::uint16_t>(raw);
        case Type::int32:
            return as<std::int32_t>(raw);
        case Type::uint32:
            return as<std::uint32_t>(raw);
        case Type::float32:
            return as<float>(raw);
        case Type::float64:
            break;
        }
        return as<double>(raw);
    }
    template <class T>
    static double as(const std::array<char, 8>& raw)
    {
        T value;
        std::memcpy(&value, raw.data(), sizeof value);
        return value;
    }

    const MeshSource& source_;
    Encoding encoding_;
    std::string_view rest_;
    std::size_t line_;
    const char* element_ = "";
    std::int64_t row_ = 0, rows_ = 0;
};

/// The scalar property x, y or z as 0, 1, 2; else -1.
int axis_of(const Property& property)
{
    return !property.list && property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z'
               ? property.name[0] - 'x'
               : -1;
}

void skip(Values& values, const Property& property)
{
    const std::int64_t count = property.list ? values.next_whole(*property.list, "the length of a list") : 1;
    for (std::int64_t i = 0; i < count; ++i) values.next(property.type);
}

std::size_t bytes_of(const Property& property)
{
    return type_bytes[static_cast<std::size_t>(property.type)];
}

template <class Number>
void copy_points(const char* rows, std::size_t stride, const std::array<std::size_t, 3>& offsets,
                 std::span<Eigen::Vector3d> vertices)
{
    for (Eigen::Vector3d& vertex : vertices) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            Number value;
            std::memcpy(&value, rows + offsets[axis], sizeof value);
            vertex[static_cast<int>(axis)] = static_cast<double>(value);
        }
        rows += stride;
    }
}

/// Reads as many vertices as the data holds, if all rows have one length and all coordinates one type; else none.
void read_plain_vertices(Values& values, const Element& element, std::vector<Eigen::Vector3d>& vertices)
{
    std::array<std::size_t, 3> offsets{};
    std::size_t stride = 0;
    std::optional<Type> type;
    for (const Property& property : element.properties) {
        if (property.list) return;
        if (const int axis = axis_of(property); axis >= 0) {
            if (type.value_or(property.type) != property.type) return;
            type = property.type, offsets[static_cast<std::size_t>(axis)] = stride;
        }
        stride += bytes_of(property);
    }
    if (type != Type::float32 && type != Type::float64) return;
    const std::string_view rows = values.plain();
    const std::size_t count = std::min(rows.size() / stride, static_cast<std::size_t>(element.count));
    reserve_large(vertices, count);
    vertices.resize(count);
    (type == Type::float32 ? copy_points<float> : copy_points<double>)(rows.data(), stride, offsets, vertices);
    const auto wrong = std::ranges::find_if(vertices, [](const Eigen::Vector3d& v) { return !(0 * v.sum() == 0); });
    for (auto v = wrong; v != vertices.end(); ++v) // finds the vertex: the sum of finite numbers may not be finite
                                                   // either
        if (!v->allFinite()) values.fail(fmt::format("coordinate of vertex {} is not finite", v - vertices.begin()));
    values.take(count * stride);
}

void read_vertices(Values& values, const Element& element, std::vector<Eigen::Vector3d>& vertices)
{
    int found = 0;
    for (const Property& property : element.properties) found |= axis_of(property) < 0 ? 0 : 1 << axis_of(property);
    if (found != 7) values.fail("element 'vertex' lacks a property x, y or z");
    read_plain_vertices(values, element, vertices);
    for (std::int64_t row = std::ssize(vertices); row < element.count; ++row) {
        values.within("vertex", row, element.count);
        Eigen::Vector3d point;
        for (const Property& property : element.properties) {
            const int axis = axis_of(property);
            if (axis < 0) {
                skip(values, property);
                continue;
            }
            point[axis] = values.next(property.type);
            if (!std::isfinite(point[axis])) values.fail(fmt::format("coordinate of vertex {} is not finite", row));
        }
        vertices.push_back(point);
    }
}

bool is_corners(const Property& property)
{
    return property.list && (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// Rows of faces in the form of nearly all files: a byte with the value three, three integers of four bytes, and other
/// properties of constant length before and after.
class PlainTriangles {
public:
    explicit PlainTriangles(const Element& element)
    {
        for (const Property& property : element.properties) {
            if (is_corners(property)) {
                const bool whole = property.type == Type::int32 || property.type == Type::uint32;
                plain_ = whole && (property.list == Type::uint8 || property.list == Type::int8);
                is_signed_ = property.type == Type::int32;
                offset_ = stride_, stride_ += 1 + sizeof(Triangle);
            } else if (property.list) {
                plain_ = false;
                return;
            } else {
                stride_ += bytes_of(property);
            }
        }
    }

    /// Reads rows up to the first of another kind; returns their number.
    std::int64_t read(Values& values, std::int64_t most, PolygonList& faces) const
    {
        if (!plain_) return 0;
        const std::string_view rows = values.plain();
        const std::size_t count = std::min(rows.size() / stride_, static_cast<std::size_t>(most));
        std::size_t row = 0, batch = 4; // small at first, for files in which kinds of rows alternate
        for (bool all = true; all && row < count; batch = std::min<std::size_t>(2 * batch, 4096)) {
            const std::size_t some = std::min(batch, count - row), read = faces.add_many(some, [&](Triangle*to) {
                return read_triangles(rows.data() + offset_ + row * stride_, some, to);
            });
            row += read, all = read == some;
        }
        values.take(row * stride_);
        return static_cast<std::int64_t>(row);
    }
    /// The largest number of triangles among `rows` faces.
    std::size_t most(const Values& values, std::int64_t rows) const
    {
        return plain_ ? std::min(values.plain().size() / stride_, static_cast<std::size_t>(rows)) : 0;
    }

private:
    /// Reads up to `most` rows that are triangles without negative indices; returns their number.
    /// @param at  position of the first triangle's corners
    std::size_t read_triangles(const char* at, std::size_t most, Triangle* to) const
    {
        const std::uint32_t minus = is_signed_ ? 0x80000000u : 0;
        std::size_t row = 0;
        for (; row < most && *at == 3; ++row, at += stride_) {
            std::memcpy(to[row].data(), at + 1, sizeof *to);
            if ((to[row][0] | to[row][1] | to[row][2]) & minus) break;
        }
        return row;
    }

    bool plain_ = false, is_signed_ = false;
    std::size_t offset_ = 0, stride_ = 0;
};

void read_faces(Values& values, const Element& element, PolygonList& faces)
{
    if (std::count_if(element.properties.begin(), element.properties.end(), is_corners) != 1)
        values.fail("element 'face' must have one list property vertex_indices");
    const PlainTriangles plain(element);
    faces.reserve(plain.most(values, element.count));
    std::vector<std::int64_t> corners;
    for (std::int64_t row = plain.read(values, element.count, faces); row < element.count;
         row += 1 + plain.read(values, element.count - row - 1, faces)) {
        values.within("face", row, element.count);
        for (const Property& property : element.properties) {
            if (!is_corners(property)) {
                skip(values, property);
                continue;
            }
            const std::int64_t count = values.next_whole(*property.list, "the number of corners");
            if (count < 1) values.fail(fmt::format("face {} has {} corners", row, count));
            const std::size_t line = values.line();
            corners.clear();
            for (std::int64_t k = 0; k < count; ++k)
                corners.push_back(values.next_whole(property.type, "a vertex number of a face"));
            if (count >= 3) faces.add(corners, line); // fewer: a point or a line
        }
    }
}

} // namespace

RawMesh read_ply(const MeshSource& source)
{
    const Header header = read_header(source);
    Values values(source, header);
    RawMesh mesh;
    PolygonList faces;
    bool has_vertices = false, has_faces = false;
    for (const Element& element : header.elements) {
        if (element.name == "vertex" && !std::exchange(has_vertices, true)) {
            read_vertices(values, element, mesh.vertices);
        } else if (element.name == "face" && !std::exchange(has_faces, true)) {
            read_faces(values, element, faces);
        } else {
            for (std::int64_t row = 0; row < element.count; ++row) {
                values.within("an element's row", row, element.count);
                for (const Property& property : element.properties) skip(values, property);
            }
        }
    }
    values.check_end();
    mesh.triangles = faces.triangulate(source, mesh.vertices, 0);
    return mesh;
}

} // namespace oncollide
