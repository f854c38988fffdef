#include <algorithm>
#include <bit>
#include <cstring>

#include <fmt/format.h>

#include <oncollide/scenes/files/mesh_source.hpp>

namespace oncollide {

namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read as it lies");

constexpr std::size_t header_bytes = 84, facet_bytes = 50;

/// The number of facets that a binary file announces.
std::uint64_t announced(std::string_view bytes)
{
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    return count;
}

void add_corner(RawMesh& mesh, const Eigen::Vector3d& point)
{
    const auto index = static_cast<std::uint32_t>(mesh.vertices.size());
    if (index % 3 == 2) mesh.triangles.push_back({index - 2, index - 1, index});
    mesh.vertices.push_back(point);
}

RawMesh read_binary(const MeshSource& source)
{
    RawMesh mesh;
    mesh.vertices.reserve(3 * announced(source.bytes)), mesh.triangles.reserve(announced(source.bytes));
    for (std::size_t facet = header_bytes; facet < source.bytes.size(); facet += facet_bytes) {
        Eigen::Matrix<float, 3, 4> columns; // normal, three corners
        std::memcpy(columns.data(), source.bytes.data() + facet, 48);
        for (int corner = 1; corner < 4; ++corner) add_corner(mesh, columns.col(corner).cast<double>());
    }
    return mesh;
}

std::string lower(std::string_view word)
{
    std::string text(word);
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
}

void expect(TextReader& text, const char* keyword, const char* second = nullptr)
{
    if (!text.next_line()) text.fail(fmt::format("the file ends where '{}' should follow", keyword));
    for (const char* wanted : {keyword, second}) {
        if (wanted == nullptr) break;
        const std::string_view word = text.word();
        if (lower(word) != wanted) text.fail(fmt::format("{} stands where '{}' should", quoted(word), wanted));
    }
}

void read_facet(TextReader& text, RawMesh& mesh)
{
    expect(text, "outer", "loop");
    for (int corner = 0; corner < 3; ++corner) {
        expect(text, "vertex");
        add_corner(mesh, text.point());
    }
    expect(text, "endloop");
    expect(text, "endfacet");
}

RawMesh read_text(const MeshSource& source)
{
    RawMesh mesh;
    TextReader text(source);
    while (text.next_line()) {
        if (const std::string_view word = text.word(); lower(word) != "solid")
            text.fail(fmt::format("{} stands where 'solid' should", quoted(word)));
        for (;;) {
            if (!text.next_line()) text.fail("the file ends without 'endsolid'");
            const std::string_view word = text.word();
            if (lower(word) == "endsolid") break;
            if (lower(word) != "facet") text.fail(fmt::format("{} stands where 'facet' should", quoted(word)));
            read_facet(text, mesh);
        }
    }
    return mesh;
}

} // namespace

bool is_binary_stl(std::string_view bytes)
{
    return bytes.size() >= header_bytes && bytes.size() == header_bytes + facet_bytes * announced(bytes);
}

RawMesh read_stl(const MeshSource& source)
{
    const std::string_view bytes = source.bytes;
    const bool binary = is_binary_stl(bytes);
    const std::string_view words = without_byte_order_mark(bytes);
    const std::size_t start = words.find_first_not_of(" \t\r\n");
    const bool text = start != words.npos && lower(words.substr(start, 5)) == "solid";
    if (!binary && !text) {
        if (bytes.size() < header_bytes)
            source.fail(fmt::format("neither text ('solid ...') nor binary STL: {} bytes are too short", bytes.size()));
        source.fail(fmt::format("binary STL of {} facets must have {} bytes, but the file has {}", announced(bytes),
                                header_bytes + facet_bytes * announced(bytes), bytes.size()));
    }
    return binary ? read_binary(source) : read_text(source);
}

} // namespace oncollide
