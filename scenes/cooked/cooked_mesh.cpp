#include <oncollide/scenes/cooked/cooked_mesh.hpp>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <numeric>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include <oncollide/base/checksum.hpp>
#include <oncollide/base/file_bytes.hpp>
#include <oncollide/scenes/cooked/cooked_format.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

constexpr double largest_cooked = 1e15; // as make_mesh has it
constexpr int most_kept_open = 256;     ///< files; of more, each read opens its file anew
std::atomic<int> kept_open = 0;

std::string_view text_of(std::span<const std::byte> bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Takes values off the front of bytes that are known to suffice.
template <class Value>
Value take(std::span<const std::byte>& bytes)
{
    Value value;
    std::memcpy(&value, bytes.data(), sizeof value);
    bytes = bytes.subspan(sizeof value);
    return value;
}

template <class Value>
void take(std::span<const std::byte>& bytes, std::vector<Value>& values)
{
    if (values.empty()) return;
    std::memcpy(static_cast<void*>(values.data()), bytes.data(), values.size() * sizeof(Value));
    bytes = bytes.subspan(values.size() * sizeof(Value));
}

} // namespace

/// Read with pread, never mapped: a file that is cut off while it is mapped ends the program (SIGBUS), and what was
/// checked could change afterwards.
class CookedMesh::File {
public:
    explicit File(const fs::path& path) : path_(path), at_(open_it()) {}
    ~File() { close_it(); }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    /// -1: not to be had.
    std::int64_t size() const
    {
        struct stat about;
        return at_ >= 0 && fstat(at_, &about) == 0 ? std::int64_t(about.st_size) : -1;
    }
    /// Keeps it open, if there are not too many, so that it can be read though it is removed meanwhile.
    void keep()
    {
        if (kept_open.fetch_add(1) < most_kept_open)
            kept_ = true;
        else
            kept_open.fetch_sub(1), close_it();
    }
    /// Why it could not; null: it was read.
    const char* read(std::uint64_t offset, std::span<std::byte> out) const
    {
        const int file = at_ >= 0 ? at_ : open_it();
        if (file < 0) return "the file can no longer be opened";
        const char* why = nullptr;
        while (!out.empty() && !why) {
            const ssize_t got = pread(file, out.data(), out.size(), static_cast<off_t>(offset));
            if (got > 0)
                out = out.subspan(std::size_t(got)), offset += std::uint64_t(got);
            else if (got == 0)
                why = "the file ends before it";
            else if (errno != EINTR)
                why = "the disk cannot read it";
        }
        if (at_ < 0) close(file);
        return why;
    }

private:
    int open_it() const { return ::open(path_.c_str(), O_RDONLY | O_CLOEXEC); }
    void close_it()
    {
        if (at_ >= 0) close(at_), at_ = -1;
        if (kept_) kept_open.fetch_sub(1), kept_ = false;
    }

    fs::path path_;
    int at_;
    bool kept_ = false;
};

const char* why_not_outline(const CookedOutline& outline)
{
    for (const Eigen::Vector3d& corner : {outline.bounds.min, outline.bounds.max})
        if (!corner.allFinite() || corner.cwiseAbs().maxCoeff() > largest_cooked)
            return "has bounds that are not finite or too far from the origin";
    if ((outline.bounds.min.array() > outline.bounds.max.array()).any()) return "has bounds without an inside";
    if (!(outline.radius >= 0 && outline.radius <= 4 * largest_cooked)) return "has a radius that cannot be";
    return nullptr;
}

CookedMesh::CookedMesh(const fs::path& path) : name_(path.string())
{
    check_readable(path);
    path_ = fs::absolute(path);
    kept_ = std::make_shared<const Top>(read_file(outline_));
}

CookedMesh::CookedMesh(const fs::path& path, const CookedOutline& outline)
    : name_(path.string()), path_(fs::absolute(path)), outline_(outline)
{
}

CookedMesh::~CookedMesh() = default;

std::shared_ptr<const CookedMesh::Top> CookedMesh::open() const
{
    if (kept_) return kept_;
    const std::lock_guard lock(mutex_);
    if (auto top = open_.lock()) return top;
    if (const auto known = faults_.find(whole_file); known != faults_.end())
        throw ChunkFault(ErrorKind::bad_data, known->second);
    try {
        check_readable(path_);
        CookedOutline found;
        const auto top = std::make_shared<const Top>(read_file(found));
        if (found != outline_) {
            contradicts_ = true;
            refuse_file("is not what the index of its tiles says: another file, or other bounds; cook the tiles again");
        }
        open_ = top;
        return top;
    } catch (const Error& error) {
        faults_.emplace(whole_file, error.what());
        throw ChunkFault(ErrorKind::bad_data, error.what());
    }
}

bool CookedMesh::is_open() const
{
    const std::lock_guard lock(mutex_);
    return kept_ || !open_.expired();
}

/// Reads and checks all but the chunks, and tells what an outline tells.
CookedMesh::Top CookedMesh::read_file(CookedOutline& outline) const
{
    CookedHeader header;
    const auto file = std::make_shared<File>(path_);
    const std::int64_t size = file->size();
    if (size < 0) throw Error(ErrorKind::no_input, name_ + ": cannot be read; check its permissions");
    if (size < std::int64_t(sizeof header)) refuse_file("is no cooked file, or cut off");
    const auto header_bytes = std::as_writable_bytes(std::span(&header, 1));
    if (const char* why = file->read(0, header_bytes)) refuse_file(why);
    if (std::memcmp(header.magic, cooked_magic, sizeof cooked_magic) != 0)
        refuse_file("is no cooked file: it does not begin with 'oncooked'");
    if (header.byte_order != cooked_byte_order)
        refuse_file("was cooked on a machine of the other byte order; cook its source here");
    if (header.version != cooked_version)
        refuse_file(fmt::format("is of version {} of the format; this program reads version {}; cook its source again",
                                header.version, cooked_version));
    if (header.header_checksum != checksum(text_of(header_bytes.first(offsetof(CookedHeader, header_checksum)))))
        refuse_file("is damaged: the header's checksum is another one");
    if (header.kind != CookedKind::mesh)
        refuse_file(fmt::format("is of an unknown kind, {}", std::uint32_t(header.kind)));
    if (header.file_bytes != std::uint64_t(size))
        refuse_file(
            fmt::format("has {} bytes, but should have {}: it is cut off or was changed", size, header.file_bytes));
    if (header.coordinate_bytes != 4 && header.coordinate_bytes != 8)
        refuse_file(fmt::format("has coordinates of {} bytes; must be 4 or 8", header.coordinate_bytes));
    if (header.topology > CookedTopology::closed || header.parts_known > 1 || (!header.parts_known && header.parts))
        refuse_file("says something unknown about the topology");
    constexpr std::uint64_t most = 0xffffffff;
    if (header.triangles == 0 || header.triangles > most || header.vertices == 0 || header.vertices > most ||
        header.zero_area > header.triangles || header.chunks == 0 || header.parts > header.triangles)
        refuse_file("has counts that cannot be");
    outline.radius = header.radius, outline.header_checksum = header.header_checksum;
    outline.triangles = header.triangles, outline.vertices = header.vertices, outline.zero_area = header.zero_area;
    std::memcpy(outline.bounds.min.data(), header.low, sizeof header.low);
    std::memcpy(outline.bounds.max.data(), header.high, sizeof header.high);
    if (const char* why = why_not_outline(outline)) refuse_file(why);
    Top top;
    top.file = file, top.coordinate_bytes = header.coordinate_bytes;
    if (header.topology != CookedTopology::unknown) top.closed = header.topology == CookedTopology::closed;

    const std::uint64_t top_bytes = std::uint64_t(header.nodes) * cooked_node_bytes +
                                    std::uint64_t(header.chunks) * sizeof(CookedChunkEntry) +
                                    header.parts * cooked_part_bytes;
    if (top_bytes > header.file_bytes - sizeof header) refuse_file("is cut off before the end of its top");
    std::vector<std::byte> bytes(top_bytes);
    if (const char* why = file->read(sizeof header, bytes)) refuse_file(why);
    if (checksum(text_of(bytes)) != header.top_checksum) refuse_file("is damaged: the top's checksum is another one");
    top.nodes.assign(bytes.begin(), bytes.begin() + std::ptrdiff_t(header.nodes) * cooked_node_bytes);
    if (header.parts_known) top.parts.emplace(header.parts);
    read_table(top, outline, std::span(bytes).subspan(top.nodes.size()), header.chunks, sizeof header + top_bytes,
               header.file_bytes);
    file->keep();
    return top;
}

/// The table of chunks, which lie one after the other from `first` to `end`, and the parts.
void CookedMesh::read_table(Top& top, const CookedOutline& outline, std::span<const std::byte> bytes,
                            std::uint32_t chunks, std::uint64_t first, std::uint64_t end) const
{
    std::uint64_t triangles = 0, vertices = 0;
    for (std::uint32_t i = 0; i < chunks; ++i) {
        const auto entry = take<CookedChunkEntry>(bytes);
        if (entry.triangles > most_chunk_triangles || entry.vertices > most_chunk_vertices || entry.vertices == 0 ||
            entry.offset != first || entry.bytes != chunk_bytes(entry.triangles, entry.vertices, top.coordinate_bytes))
            refuse_file(fmt::format("says of chunk {} what cannot be", i));
        if (entry.triangles > 0 && top.tree_chunks < i) refuse_file(fmt::format("has chunk {} behind an empty one", i));
        if (entry.triangles > 0) top.tree_chunks = i + std::size_t{1};
        first += entry.bytes, triangles += entry.triangles, vertices += entry.vertices;
        top.chunks.push_back({entry.offset, entry.bytes, entry.checksum, entry.triangles, entry.vertices});
    }
    if (first != end) refuse_file("has chunks that do not fill it");
    if (triangles != outline.triangles || vertices < outline.vertices)
        refuse_file(fmt::format("has {} triangles and {} vertices in its chunks, but {} and {} in its header",
                                triangles, vertices, outline.triangles, outline.vertices));
    if (!top.parts) return;
    for (Part& part : *top.parts)
        for (Eigen::Vector3d& point : part) {
            for (double& coordinate : point) coordinate = take<double>(bytes);
            if (!((point.array() >= outline.bounds.min.array()).all() &&
                  (point.array() <= outline.bounds.max.array()).all()))
                refuse_file("has a part outside its bounds");
        }
}

void CookedMesh::refuse_file(const std::string& why) const
{
    throw ChunkFault(ErrorKind::bad_data, fmt::format("{}: {}", name_, why));
}

void CookedMesh::refuse_chunk(std::size_t chunk, const std::string& why) const
{
    refuse_chunk(*open(), chunk, why);
}

void CookedMesh::refuse_chunk(const Top& top, std::size_t chunk, const std::string& why) const
{
    std::string what = fmt::format("{}: chunk {} of {}: {}; cook the file again", name_, chunk, top.chunks.size(), why);
    {
        const std::lock_guard lock(mutex_);
        what = faults_.emplace(chunk, what).first->second;
    }
    throw ChunkFault(ErrorKind::bad_data, what);
}

std::vector<std::string> CookedMesh::faults() const
{
    const std::lock_guard lock(mutex_);
    std::vector<std::string> lines;
    for (const auto& [chunk, what] : faults_) lines.push_back(what);
    return lines;
}

void CookedMesh::read(std::size_t chunk, Chunk& out) const
{
    {
        const std::lock_guard lock(mutex_);
        if (const auto known = faults_.find(chunk); known != faults_.end())
            throw ChunkFault(ErrorKind::bad_data, known->second);
    }
    const std::shared_ptr<const Top> top = open();
    const Top::Entry& entry = top->chunks[chunk];
    std::vector<std::byte> bytes(entry.bytes);
    if (const char* why = top->file->read(entry.offset, bytes)) refuse_chunk(*top, chunk, why);
    if (checksum(text_of(bytes)) != entry.checksum) refuse_chunk(*top, chunk, "the checksum is another one");
    unpack(*top, chunk, bytes, out);
}

void CookedMesh::unpack(const Top& top, std::size_t chunk, std::span<const std::byte> bytes, Chunk& out) const
{
    const Top::Entry& entry = top.chunks[chunk];
    out.vertices.resize(entry.vertices), out.vertex_numbers.resize(entry.vertices);
    out.triangles.resize(entry.triangles), out.numbers.resize(entry.triangles);
    if (top.coordinate_bytes == 4) {
        std::vector<Eigen::Vector3f> floats(entry.vertices);
        take(bytes, floats);
        std::ranges::transform(floats, out.vertices.begin(), [](const auto& v) { return v.template cast<double>(); });
    } else {
        take(bytes, out.vertices);
    }
    take(bytes, out.vertex_numbers);
    std::vector<std::array<std::uint16_t, 3>> corners(entry.triangles);
    take(bytes, corners), take(bytes, out.numbers);

    for (const Eigen::Vector3d& v : out.vertices)
        if (!(v.array().abs() <= largest_cooked).all()) // nor is what is no number
            refuse_chunk(top, chunk, "a coordinate is not finite or too far from the origin");
    for (std::size_t i = 0; i < corners.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            if (corners[i][k] >= entry.vertices) refuse_chunk(top, chunk, "a triangle has a corner that is not there");
            out.triangles[i][k] = corners[i][k];
        }
    const auto below = [](const std::vector<std::uint32_t>& numbers, std::size_t end) {
        return std::ranges::all_of(numbers, [=](std::uint32_t number) { return number < end; });
    };
    if (!below(out.vertex_numbers, outline_.vertices) || !below(out.numbers, outline_.triangles))
        refuse_chunk(top, chunk, "a number of a vertex or a triangle is beyond their count");
    if (std::ranges::any_of(bytes, [](std::byte byte) { return byte != std::byte{}; }))
        refuse_chunk(top, chunk, "something stands behind its end");
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
                refuse_chunk(c, fmt::format("vertex {} is somewhere else in another chunk", number));
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
    if (seen != outline_.vertices) refuse_file(fmt::format("has {} of its {} vertices", seen, outline_.vertices));
    Mesh mesh = make_mesh(name_, std::move(vertices), std::move(triangles));
    if (mesh.bounds.min != outline_.bounds.min || mesh.bounds.max != outline_.bounds.max ||
        mesh.zero_area != outline_.zero_area)
        refuse_file("has triangles that contradict its header");
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
