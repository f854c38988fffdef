#include <oncollide/scenes/cooked/cooked_mesh.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/cooked/cooked_file.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

constexpr double largest_cooked = 1e15; // the limit of make_mesh

} // namespace

const char* why_not_outline(const CookedOutline& outline)
{
    for (const Eigen::Vector3d& corner : {outline.bounds.min, outline.bounds.max})
        if (!corner.allFinite() || corner.cwiseAbs().maxCoeff() > largest_cooked)
            return "has bounds that are not finite or too far from the origin";
    if ((outline.bounds.min.array() > outline.bounds.max.array()).any()) return "has bounds without an inside";
    if (!(outline.radius >= 0 && outline.radius <= 4 * largest_cooked)) return "has an impossible radius";
    return nullptr;
}

CookedMesh::CookedMesh(const fs::path& path) : file_(std::make_unique<CookedFile>(path))
{
    kept_ = std::make_shared<const Top>(read_file(outline_));
}

CookedMesh::CookedMesh(const fs::path& path, const CookedOutline& outline)
    : file_(std::make_unique<CookedFile>(path)), outline_(outline)
{
}

CookedMesh::~CookedMesh() = default;

const std::string& CookedMesh::name() const
{
    return file_->name();
}

std::vector<std::string> CookedMesh::faults() const
{
    return file_->faults();
}

std::shared_ptr<const CookedMesh::Top> CookedMesh::open() const
{
    if (kept_) return kept_;
    const std::lock_guard lock(mutex_);
    if (auto top = open_.lock()) return top;
    file_->check_known(CookedFile::whole);
    try {
        CookedOutline found;
        const auto top = std::make_shared<const Top>(read_file(found));
        if (found != outline_) {
            contradicts_ = true;
            file_->refuse("does not match the index of its tiles: another file, or other bounds; cook the tiles again");
        }
        open_ = top;
        return top;
    } catch (const Error& error) {
        file_->note(CookedFile::whole, error.what());
        throw ChunkFault(ErrorKind::bad_data, error.what());
    }
}

bool CookedMesh::is_open() const
{
    const std::lock_guard lock(mutex_);
    return kept_ || !open_.expired();
}

/// Reads and checks everything except the chunks, and fills in the outline.
CookedMesh::Top CookedMesh::read_file(CookedOutline& outline) const
{
    const CookedFile::Opened opened = file_->open(CookedKind::mesh);
    const CookedHeader& header = opened.header;
    if (header.coordinate_bytes != 4 && header.coordinate_bytes != 8)
        file_->refuse(fmt::format("has coordinates of {} bytes; must be 4 or 8", header.coordinate_bytes));
    if (header.topology > CookedTopology::closed) file_->refuse("has an unknown topology");
    constexpr std::uint64_t most = 0xffffffff;
    if (header.triangles == 0 || header.triangles > most || header.vertices == 0 || header.vertices > most ||
        header.zero_area > header.triangles || header.parts > header.triangles || header.chunks == 0)
        file_->refuse("has impossible counts");
    outline.radius = header.radius, outline.header_checksum = header.header_checksum;
    outline.triangles = header.triangles, outline.vertices = header.vertices, outline.zero_area = header.zero_area;
    std::memcpy(outline.bounds.min.data(), header.low, sizeof header.low);
    std::memcpy(outline.bounds.max.data(), header.high, sizeof header.high);
    if (const char* why = why_not_outline(outline)) file_->refuse(why);
    Top top;
    top.file = opened.handle, top.coordinate_bytes = header.coordinate_bytes;
    if (header.topology != CookedTopology::unknown) top.closed = header.topology == CookedTopology::closed;
    const auto nodes = opened.nodes();
    top.nodes.assign(nodes.begin(), nodes.end());
    take_table(top, outline, opened);
    top.parts = opened.parts();
    if (top.parts) file_->check_parts(*top.parts, outline.bounds);
    return top;
}

void CookedMesh::take_table(Top& top, const CookedOutline& outline, const CookedFile::Opened& opened) const
{
    top.chunks = opened.table();
    std::uint64_t triangles = 0, vertices = 0;
    for (std::size_t i = 0; i < top.chunks.size(); ++i) {
        const CookedChunkEntry& entry = top.chunks[i];
        if (entry.triangles > most_chunk_triangles || entry.vertices > most_chunk_vertices || entry.vertices == 0)
            file_->refuse_entry(i);
        if (entry.triangles > 0 && top.tree_chunks < i)
            file_->refuse(fmt::format("has chunk {} after an empty chunk", i));
        if (entry.triangles > 0) top.tree_chunks = i + 1;
        triangles += entry.triangles, vertices += entry.vertices;
    }
    file_->check_table(opened, top.chunks, [&](const CookedChunkEntry& entry, std::size_t) {
        return chunk_bytes(entry.triangles, entry.vertices, top.coordinate_bytes);
    });
    if (triangles != outline.triangles || vertices < outline.vertices)
        file_->refuse(fmt::format("has {} triangles and {} vertices in its chunks, but {} and {} in its header",
                                  triangles, vertices, outline.triangles, outline.vertices));
}

void CookedMesh::refuse_chunk(std::size_t chunk, const std::string& why) const
{
    file_->refuse_chunk(chunk, open()->chunks.size(), why);
}

void CookedMesh::read(std::size_t chunk, Chunk& out) const
{
    file_->check_known(chunk);
    const std::shared_ptr<const Top> top = open();
    unpack(*top, chunk, file_->read(*top->file, top->chunks[chunk], chunk, top->chunks.size()), out);
}

void CookedMesh::unpack(const Top& top, std::size_t chunk, std::span<const std::byte> bytes, Chunk& out) const
{
    ONCOLLIDE_ASSERT(chunk < top.chunks.size() && bytes.size() == top.chunks[chunk].bytes);
    const CookedChunkEntry& entry = top.chunks[chunk];
    out.vertices.resize(entry.vertices), out.vertex_numbers.resize(entry.vertices);
    out.triangles.resize(entry.triangles), out.numbers.resize(entry.triangles);
    if (top.coordinate_bytes == 4) {
        std::vector<Eigen::Vector3f> floats(entry.vertices);
        take(bytes, std::span(floats));
        std::ranges::transform(floats, out.vertices.begin(), [](const auto& v) { return v.template cast<double>(); });
    } else {
        take(bytes, std::span(out.vertices));
    }
    take(bytes, std::span(out.vertex_numbers));
    std::vector<std::array<std::uint16_t, 3>> corners(entry.triangles);
    take(bytes, std::span(corners)), take(bytes, std::span(out.numbers));

    for (const Eigen::Vector3d& v : out.vertices)
        if (!(v.array().abs() <= largest_cooked).all()) // also false for NaN
            file_->refuse_chunk(chunk, top.chunks.size(), "a coordinate is not finite or too far from the origin");
    for (std::size_t i = 0; i < corners.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            if (corners[i][k] >= entry.vertices)
                file_->refuse_chunk(chunk, top.chunks.size(), "a triangle has a corner out of range");
            out.triangles[i][k] = corners[i][k];
        }
    const auto below = [](const std::vector<std::uint32_t>& numbers, std::size_t end) {
        return std::ranges::all_of(numbers, [=](std::uint32_t number) { return number < end; });
    };
    if (!below(out.vertex_numbers, outline_.vertices) || !below(out.numbers, outline_.triangles))
        file_->refuse_chunk(chunk, top.chunks.size(), "the number of a vertex or a triangle is out of range");
    if (std::ranges::any_of(bytes, [](std::byte byte) { return byte != std::byte{}; }))
        file_->refuse_chunk(chunk, top.chunks.size(), "there is data after its end");
}

Mesh CookedMesh::whole() const
{
    std::vector<Eigen::Vector3d> vertices(outline_.vertices);
    std::vector<Triangle> triangles(outline_.triangles);
    std::vector<bool> has_vertex(outline_.vertices), has_triangle(outline_.triangles);
    std::size_t seen = 0;
    const std::shared_ptr<const Top> top = open();
    Chunk chunk;
    for (std::size_t c = 0; c < top->chunks.size(); ++c) {
        read(c, chunk);
        for (std::size_t i = 0; i < chunk.vertices.size(); ++i) {
            const std::uint32_t number = chunk.vertex_numbers[i];
            if (has_vertex[number] &&
                std::memcmp(vertices[number].data(), chunk.vertices[i].data(), 3 * sizeof(double)) != 0)
                refuse_chunk(c, fmt::format("vertex {} has another position in another chunk", number));
            seen += !has_vertex[number];
            has_vertex[number] = true, vertices[number] = chunk.vertices[i];
        }
        for (std::size_t i = 0; i < chunk.triangles.size(); ++i) {
            const std::uint32_t number = chunk.numbers[i];
            if (has_triangle[number]) refuse_chunk(c, fmt::format("triangle {} is there twice", number));
            has_triangle[number] = true;
            for (std::size_t k = 0; k < 3; ++k) triangles[number][k] = chunk.vertex_numbers[chunk.triangles[i][k]];
        }
    }
    if (seen != outline_.vertices) file_->refuse(fmt::format("has {} of its {} vertices", seen, outline_.vertices));
    Mesh mesh = make_mesh(name(), std::move(vertices), std::move(triangles));
    if (mesh.bounds.min != outline_.bounds.min || mesh.bounds.max != outline_.bounds.max ||
        mesh.zero_area != outline_.zero_area)
        file_->refuse("has triangles that contradict its header");
    return mesh;
}

std::size_t CookedMesh::Top::bytes() const
{
    return nodes.size() + chunks.size() * sizeof(chunks[0]) + (parts ? parts->size() * sizeof(Part) : 0);
}

bool is_cooked(const fs::path& path)
{
    return path.extension() == ".cooked";
}

} // namespace oncollide
