#include <oncollide/scenes/cooked/cooked_file.hpp>

#include <atomic>
#include <cstring>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/checksum.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/random_access_file.hpp>

namespace oncollide {

namespace {

namespace fs = std::filesystem;

constexpr int most_kept_open = 256; ///< files; with more files, each read opens its file again
std::atomic<int> kept_open = 0;

std::string_view text_of(std::span<const std::byte> bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

} // namespace

class CookedFile::Handle {
public:
    explicit Handle(const fs::path& path) : path_(path), file_(path) {}
    ~Handle() { close(); }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;

    /// -1: unavailable.
    std::int64_t size() const { return file_.size(); }
    /// Keeps the file open, unless too many are, so that it stays readable after it is deleted.
    void keep()
    {
        if (kept_open.fetch_add(1) < most_kept_open)
            kept_ = true;
        else
            kept_open.fetch_sub(1), close();
    }
    /// Returns why reading failed; null: success.
    const char* read(std::uint64_t offset, std::span<std::byte> out) const
    {
        if (file_.is_open()) return file_.read(offset, out);
        const RandomAccessFile again(path_);
        return again.is_open() ? again.read(offset, out) : "the file can no longer be opened";
    }

private:
    void close()
    {
        file_.close();
        if (kept_) kept_open.fetch_sub(1), kept_ = false;
    }

    fs::path path_;
    RandomAccessFile file_;
    bool kept_ = false;
};

CookedFile::CookedFile(const fs::path& path) : name_(path.string()), path_(absolute_path(path)) {}

CookedFile::~CookedFile() = default;

CookedFile::Opened CookedFile::open(CookedKind kind) const
{
    check_readable(path_);
    Opened opened;
    CookedHeader& header = opened.header;
    const auto handle = std::make_shared<Handle>(path_);
    const std::int64_t size = handle->size();
    if (size < 0) throw Error(ErrorKind::no_input, name_ + ": cannot be read; check its permissions");
    if (size < std::int64_t(sizeof header)) refuse("is not a cooked file, or is cut off");
    const auto header_bytes = std::as_writable_bytes(std::span(&header, 1));
    if (const char* why = handle->read(0, header_bytes)) refuse(why);
    if (std::memcmp(header.magic, cooked_magic, sizeof cooked_magic) != 0)
        refuse("is not a cooked file: it does not begin with 'oncooked'");
    if (header.byte_order != cooked_byte_order)
        refuse("was cooked on a machine of the other byte order; cook its source here");
    if (header.version != cooked_version)
        refuse(fmt::format("is of version {} of the format; this program reads version {}; cook its source again",
                           header.version, cooked_version));
    if (header.header_checksum != checksum(text_of(header_bytes.first(offsetof(CookedHeader, header_checksum)))))
        refuse("is damaged: the header's checksum does not match");
    if (header.kind < CookedKind::mesh || header.kind > CookedKind::map)
        refuse(fmt::format("is of an unknown kind, {}", std::uint32_t(header.kind)));
    if (header.kind != kind) refuse(fmt::format("holds a {}, not a {}", name_of(header.kind), name_of(kind)));
    if (header.file_bytes != std::uint64_t(size))
        refuse(fmt::format("has {} bytes, but should have {}: it is cut off or was changed", size, header.file_bytes));
    if (header.parts > header.file_bytes || header.parts_known > 1 || (!header.parts_known && header.parts))
        refuse("has impossible counts");
    const std::uint64_t top_bytes = header.nodes * std::uint64_t(cooked_node_bytes(kind)) +
                                    header.chunks * std::uint64_t(sizeof(CookedChunkEntry)) +
                                    header.parts * cooked_part_bytes + cooked_record_bytes(kind);
    if (top_bytes > header.file_bytes - sizeof header) refuse("is cut off before the end of its top");
    opened.top.resize(top_bytes);
    if (const char* why = handle->read(sizeof header, opened.top)) refuse(why);
    if (checksum(text_of(opened.top)) != header.top_checksum) refuse("is damaged: the top's checksum does not match");
    handle->keep();
    opened.handle = handle;
    return opened;
}

std::span<const std::byte> CookedFile::Opened::nodes() const
{
    return std::span(top).first(header.nodes * std::size_t(cooked_node_bytes(header.kind)));
}

std::vector<CookedChunkEntry> CookedFile::Opened::table() const
{
    std::vector<CookedChunkEntry> entries(header.chunks);
    std::span<const std::byte> bytes = std::span(top).subspan(nodes().size());
    take(bytes, std::span(entries));
    return entries;
}

std::span<const std::byte> CookedFile::Opened::record() const
{
    return std::span(top).last(cooked_record_bytes(header.kind));
}

std::optional<std::vector<CookedPart>> CookedFile::Opened::parts() const
{
    if (!header.parts_known) return {};
    std::vector<CookedPart> parts(header.parts);
    auto bytes = std::span(top).last(header.parts * cooked_part_bytes + cooked_record_bytes(header.kind));
    take(bytes, std::span(parts));
    return parts;
}

std::vector<std::byte> CookedFile::read(const Handle& handle, const CookedChunkEntry& entry, std::size_t chunk,
                                        std::size_t count) const
{
    ONCOLLIDE_ASSERT(chunk < count);
    check_known(chunk);
    std::vector<std::byte> bytes(entry.bytes);
    if (const char* why = handle.read(entry.offset, bytes)) refuse_chunk(chunk, count, why);
    if (checksum(text_of(bytes)) != entry.checksum) refuse_chunk(chunk, count, "the checksum does not match");
    return bytes;
}

void CookedFile::check_parts(std::span<const CookedPart> parts, const Aabb& bounds) const
{
    for (const CookedPart& part : parts)
        for (const Eigen::Vector3d& point : part)
            if (!((point.array() >= bounds.min.array()).all() && (point.array() <= bounds.max.array()).all()))
                refuse("has a part outside its bounds");
}

void CookedFile::refuse(const std::string& why) const
{
    throw ChunkFault(ErrorKind::bad_data, fmt::format("{}: {}", name_, why));
}

void CookedFile::refuse_entry(std::size_t chunk) const
{
    refuse(fmt::format("has an impossible entry for chunk {}", chunk));
}

void CookedFile::refuse_chunk(std::size_t chunk, std::size_t count, const std::string& why) const
{
    ONCOLLIDE_ASSERT(chunk < count);
    std::string what = fmt::format("{}: chunk {} of {}: {}; cook the file again", name_, chunk, count, why);
    {
        const std::lock_guard lock(mutex_);
        what = faults_.emplace(chunk, what).first->second;
    }
    throw ChunkFault(ErrorKind::bad_data, what);
}

void CookedFile::note(std::size_t chunk, const std::string& what) const
{
    const std::lock_guard lock(mutex_);
    faults_.emplace(chunk, what);
}

void CookedFile::check_known(std::size_t chunk) const
{
    const std::lock_guard lock(mutex_);
    if (const auto known = faults_.find(chunk); known != faults_.end())
        throw ChunkFault(ErrorKind::bad_data, known->second);
}

std::vector<std::string> CookedFile::faults() const
{
    const std::lock_guard lock(mutex_);
    std::vector<std::string> lines;
    for (const auto& [chunk, what] : faults_) lines.push_back(what);
    return lines;
}

CookedKind cooked_kind(const fs::path& path)
{
    check_readable(path);
    CookedHeader header{};
    const CookedFile::Handle handle(path);
    const char* const why = handle.read(0, std::as_writable_bytes(std::span(&header, 1)));
    // Other faults are reported when it is opened as that kind.
    const bool known = !why && header.kind >= CookedKind::mesh && header.kind <= CookedKind::map;
    return known ? header.kind : CookedKind::mesh;
}

} // namespace oncollide
