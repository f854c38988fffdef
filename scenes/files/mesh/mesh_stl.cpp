#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/scenes/files/mesh/facet_welder.hpp>
#include <oncollide/scenes/files/mesh/welder.hpp>

namespace oncollide {

namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read as it lies");

constexpr std::size_t header_bytes = 84;

std::uint64_t announced(std::string_view header)
{
    std::uint32_t count = 0;
    std::memcpy(&count, header.data() + 80, sizeof count);
    return count;
}

[[noreturn]] void fail_infinite(const std::string& name, const char* facets, std::size_t first)
{
    for (std::size_t facet = 0;; ++facet)
        for (std::size_t k = 0; k < 9; ++k) {
            float x = 0;
            std::memcpy(&x, facets + facet * FacetWelder::facet_bytes + FacetWelder::corners_at + 4 * k, sizeof x);
            if (!std::isfinite(x))
                MeshSource{name, {}}.fail(fmt::format("a corner of facet {} is not finite", first + facet));
        }
}

/// @param read reads that many bytes of the file, starting after the header
RawMesh read_facets(const std::string& name, std::size_t facets, FunctionRef<void(char*, std::size_t)> read)
{
    constexpr std::size_t batch = FacetWelder::batch, block = 16 * batch;
    std::vector<char> bytes(std::min(facets, block) * FacetWelder::facet_bytes + FacetWelder::bytes_behind);
    RawMesh mesh;
    reserve_large(mesh.triangles, facets);
    FacetWelder weld(facets);
    for (std::size_t first = 0; first < facets; first += batch) {
        const std::size_t count = std::min(batch, facets - first);
        mesh.triangles.resize(first + count);
        char* const at = bytes.data() + first % block * FacetWelder::facet_bytes;
        if (first % block == 0) read(at, std::min(facets - first, block) * FacetWelder::facet_bytes);
        if (!weld.add(at, count, &mesh.triangles[first])) fail_infinite(name, at, first);
    }
    mesh.vertices = weld.take();
    return mesh;
}

RawMesh read_binary(const MeshSource& source)
{
    const char* rest = source.bytes.data() + header_bytes;
    return read_facets(source.name, announced(source.bytes),
                       [&](char* to, std::size_t size) { std::memcpy(to, std::exchange(rest, rest + size), size); });
}

/// @param header the beginning of the file
bool is_binary(std::string_view header, std::uintmax_t size)
{
    return header.size() >= header_bytes && size == header_bytes + FacetWelder::facet_bytes * announced(header);
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
    return is_binary(bytes, bytes.size());
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
                                header_bytes + FacetWelder::facet_bytes * announced(bytes), bytes.size()));
    }
    return binary ? read_binary(source) : read_text(source);
}

RawMesh read_stl_file(const std::filesystem::path& path, std::uintmax_t most)
{
    FileReader file(path, most);
    std::array<char, header_bytes> header;
    const std::string_view begin(header.data(), std::min<std::uintmax_t>(file.size(), header.size()));
    file.read(header.data(), begin.size());
    if (is_binary(begin, file.size()))
        return read_facets(path.string(), announced(begin), [&](char* to, std::size_t size) { file.read(to, size); });
    FileBytes bytes(file.size());
    begin.copy(bytes.data(), begin.size());
    file.read(bytes.data() + begin.size(), bytes.size() - begin.size());
    return read_stl({path.string(), bytes});
}

} // namespace oncollide
