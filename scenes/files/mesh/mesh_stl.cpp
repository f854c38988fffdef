#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include <oncollide/scenes/files/mesh/welder.hpp>

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

[[noreturn]] void fail_infinite(const MeshSource& source, std::size_t facet)
{
    for (;; ++facet)
        for (std::size_t k = 3; k < 12; ++k) {
            float x = 0;
            std::memcpy(&x, source.bytes.data() + header_bytes + facet * facet_bytes + 4 * k, sizeof x);
            if (!std::isfinite(x)) source.fail(fmt::format("a corner of facet {} is not finite", facet));
        }
}

RawMesh read_binary(const MeshSource& source)
{
    const std::size_t facets = announced(source.bytes);
    constexpr std::size_t batch = 16;
    RawMesh mesh;
    reserve_large(mesh.triangles, facets + batch);
    mesh.triangles.resize(facets);
    Welder weld;
    weld.reserve(facets / 2); // a closed surface has about as many; a soup takes more room as it needs it
    std::array<Eigen::Vector3d, 3 * batch> corners;
    const char* at = source.bytes.data() + header_bytes;
    for (std::size_t first = 0; first < facets; first += batch) {
        const std::size_t count = std::min(batch, facets - first);
        float sum = 0; // of zeros, if all is finite
        for (std::size_t i = 0; i < count; ++i, at += facet_bytes) {
            std::array<float, 9> points;
            std::memcpy(points.data(), at + 12, sizeof points); // after the normal
            for (std::size_t k = 0; k < 3; ++k) corners[3 * i + k] = Eigen::Vector3f(&points[3 * k]).cast<double>();
            for (const float x : points) sum += 0 * x;
        }
        if (sum != 0) fail_infinite(source, first);
        weld.add({corners.data(), 3 * count}, mesh.triangles[first].data());
    }
    mesh.vertices = weld.take();
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

Triangle read_facet(TextReader& text, Welder& weld)
{
    expect(text, "outer", "loop");
    Triangle triangle;
    for (std::uint32_t& corner : triangle) {
        expect(text, "vertex");
        corner = weld.add(text.point());
    }
    expect(text, "endloop");
    expect(text, "endfacet");
    return triangle;
}

RawMesh read_text(const MeshSource& source)
{
    RawMesh mesh;
    Welder weld;
    TextReader text(source);
    while (text.next_line()) {
        if (const std::string_view word = text.word(); lower(word) != "solid")
            text.fail(fmt::format("{} stands where 'solid' should", quoted(word)));
        for (;;) {
            if (!text.next_line()) text.fail("the file ends without 'endsolid'");
            const std::string_view word = text.word();
            if (lower(word) == "endsolid") break;
            if (lower(word) != "facet") text.fail(fmt::format("{} stands where 'facet' should", quoted(word)));
            mesh.triangles.push_back(read_facet(text, weld));
        }
    }
    mesh.vertices = weld.take();
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
