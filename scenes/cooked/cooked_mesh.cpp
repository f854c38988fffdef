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
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(Value));
    bytes = bytes.subspan(values.size() * sizeof(Value));
}

} // namespace

/// Read with pread, never mapped: a file that is cut off while it is mapped ends the program (SIGBUS), and what was
/// checked could change afterwards.
class CookedMesh::File {
public:
    explicit File(const fs::path& path) : path_(fs::absolute(path)), at_(open_it())
    {
        if (at_ < 0) throw Error(ErrorKind::no_input, path.string() + ": cannot be read; check its permissions");
    }
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
    int open_it() const { return open(path_.c_str(), O_RDONLY | O_CLOEXEC); }
    void close_it()
    {
        if (at_ >= 0) close(at_), at_ = -1;
        if (kept_) kept_open.fetch_sub(1), kept_ = false;
    }

    fs::path path_;
    int at_;
    bool kept_ = false;
};

CookedMesh::CookedMesh(const fs::path& path) : name_(path.string())
{
    check_readable(path);
    file_ = std::make_unique<File>(path);
    CookedHeader header;
    const std::int64_t size = file_->size();
    if (size < std::int64_t(sizeof header)) refuse_file("is no cooked file, or cut off");
    const auto header_bytes = std::as_writable_bytes(std::span(&header, 1));
    if (const char* why = file_->read(0, header_bytes)) refuse_file(why);
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
    file_bytes_ = header.file_bytes, coordinate_bytes_ = header.coordinate_bytes;
    triangles_ = header.triangles, vertices_ = header.vertices, zero_area_ = header.zero_area;
    radius_ = header.radius;
    std::memcpy(bounds_.min.data(), header.low, sizeof header.low);
    std::memcpy(bounds_.max.data(), header.high, sizeof header.high);
    for (const Eigen::Vector3d& corner : {bounds_.min, bounds_.max})
        if (!corner.allFinite() || corner.cwiseAbs().maxCoeff() > largest_cooked)
            refuse_file("has bounds that are not finite or too far from the origin");
    if ((bounds_.min.array() > bounds_.max.array()).any()) refuse_file("has bounds without an inside");
    if (!(radius_ >= 0 && radius_ <= 4 * largest_cooked)) refuse_file("has a radius that cannot be");
    if (header.topology != CookedTopology::unknown) closed_ = header.topology == CookedTopology::closed;

    const std::uint64_t top = std::uint64_t(header.nodes) * cooked_node_bytes +
                              std::uint64_t(header.chunks) * sizeof(CookedChunkEntry) +
                              header.parts * cooked_part_bytes;
    if (top > file_bytes_ - sizeof header) refuse_file("is cut off before the end of its top");
    std::vector<std::byte> bytes(top);
    if (const char* why = file_->read(sizeof header, bytes)) refuse_file(why);
    if (checksum(text_of(bytes)) != header.top_checksum) refuse_file("is damaged: the top's checksum is another one");
    nodes_.assign(bytes.begin(), bytes.begin() + std::ptrdiff_t(header.nodes) * cooked_node_bytes);
    if (header.parts_known) parts_.emplace(header.parts);
    read_top(std::span(bytes).subspan(nodes_.size()), header.chunks, sizeof header + top);
    file_->keep();
}

CookedMesh::~CookedMesh() = default;

/// The table of chunks, which lie one after the other from `first` to the end of the file, and the parts.
void CookedMesh::read_top(std::span<const std::byte> top, std::uint32_t chunks, std::uint64_t first)
{
    std::uint64_t triangles = 0, vertices = 0;
    for (std::uint32_t i = 0; i < chunks; ++i) {
        const auto entry = take<CookedChunkEntry>(top);
        if (entry.triangles > most_chunk_triangles || entry.vertices > most_chunk_vertices || entry.vertices == 0 ||
            entry.offset != first || entry.bytes != chunk_bytes(entry.triangles, entry.vertices, coordinate_bytes_))
            refuse_file(fmt::format("says of chunk {} what cannot be", i));
        if (entry.triangles > 0 && tree_chunks_ < i) refuse_file(fmt::format("has chunk {} behind an empty one", i));
        if (entry.triangles > 0) tree_chunks_ = i + std::size_t{1};
        first += entry.bytes, triangles += entry.triangles, vertices += entry.vertices;
        chunks_.push_back({entry.offset, entry.bytes, entry.checksum, entry.triangles, entry.vertices});
    }
    if (first != file_bytes_) refuse_file("has chunks that do not fill it");
    if (triangles != triangles_ || vertices < vertices_)
        refuse_file(fmt::format("has {} triangles and {} vertices in its chunks, but {} and {} in its header",
                                triangles, vertices, triangles_, vertices_));
    if (!parts_) return;
    for (Part& part : *parts_)
        for (Eigen::Vector3d& point : part) {
            for (double& coordinate : point) coordinate = take<double>(top);
            if (!((point.array() >= bounds_.min.array()).all() && (point.array() <= bounds_.max.array()).all()))
                refuse_file("has a part outside its bounds");
        }
}

void CookedMesh::refuse_file(const std::string& why) const
{
    throw ChunkFault(ErrorKind::bad_data, fmt::format("{}: {}", name_, why));
}

void CookedMesh::refuse_chunk(std::size_t chunk, const std::string& why) const
{
    std::string what = fmt::format("{}: chunk {} of {}: {}; cook the file again", name_, chunk, chunks_.size(), why);
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
    const Entry& entry = chunks_[chunk];
    std::vector<std::byte> bytes(entry.bytes);
    if (const char* why = file_->read(entry.offset, bytes)) refuse_chunk(chunk, why);
    if (checksum(text_of(bytes)) != entry.checksum) refuse_chunk(chunk, "the checksum is another one");
    unpack(chunk, bytes, out);
}

void CookedMesh::unpack(std::size_t chunk, std::span<const std::byte> bytes, Chunk& out) const
{
    const Entry& entry = chunks_[chunk];
    out.vertices.resize(entry.vertices), out.vertex_numbers.resize(entry.vertices);
    out.triangles.resize(entry.triangles), out.numbers.resize(entry.triangles);
    if (coordinate_bytes_ == 4) {
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
            refuse_chunk(chunk, "a coordinate is not finite or too far from the origin");
    for (std::size_t i = 0; i < corners.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            if (corners[i][k] >= entry.vertices) refuse_chunk(chunk, "a triangle has a corner that is not there");
            out.triangles[i][k] = corners[i][k];
        }
    const auto below = [](const std::vector<std::uint32_t>& numbers, std::size_t end) {
        return std::ranges::all_of(numbers, [=](std::uint32_t number) { return number < end; });
    };
    if (!below(out.vertex_numbers, vertices_) || !below(out.numbers, triangles_))
        refuse_chunk(chunk, "a number of a vertex or a triangle is beyond their count");
    if (std::ranges::any_of(bytes, [](std::byte byte) { return byte != std::byte{}; }))
        refuse_chunk(chunk, "something stands behind its end");
}

Mesh CookedMesh::whole() const
{
    std::vector<Eigen::Vector3d> vertices(vertices_);
    std::vector<Triangle> triangles(triangles_);
    std::vector<bool> has_vertex(vertices_), has_triangle(triangles_);
    std::size_t seen = 0;
    Chunk chunk;
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
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
    if (seen != vertices_) refuse_file(fmt::format("has {} of its {} vertices", seen, vertices_));
    Mesh mesh = make_mesh(name_, std::move(vertices), std::move(triangles));
    if (mesh.bounds.min != bounds_.min || mesh.bounds.max != bounds_.max || mesh.zero_area != zero_area_)
        refuse_file("has triangles that contradict its header");
    return mesh;
}

std::size_t CookedMesh::bytes() const
{
    return nodes_.size() + chunks_.size() * sizeof(chunks_[0]) + (parts_ ? parts_->size() * sizeof(Part) : 0);
}

bool is_cooked(const fs::path& path)
{
    return path.extension() == ".cooked";
}

} // namespace oncollide
