#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/scenes/cooked/chunk_fault.hpp>
#include <oncollide/scenes/cooked/cooked_format.hpp>

namespace oncollide {

/// The six points of a connected part with the least and greatest x, y and z.
using CookedPart = std::array<Eigen::Vector3d, 6>;
static_assert(sizeof(CookedPart) == cooked_part_bytes);

/// A cooked file of any kind (docs/cooked.md): its header, its top, its chunks, and the faults found so far. Each part
/// is checked against its checksum when it is read. Const calls are safe from many threads at once.
class CookedFile {
public:
    /// Does not access the file.
    explicit CookedFile(const std::filesystem::path& path);
    ~CookedFile();
    CookedFile(const CookedFile&) = delete;
    CookedFile& operator=(const CookedFile&) = delete;

    const std::string& name() const { return name_; }           ///< the path, for errors
    const std::filesystem::path& path() const { return path_; } ///< absolute

    class Handle; ///< the open file
    struct Opened {
        std::shared_ptr<const Handle> handle;
        CookedHeader header;
        std::vector<std::byte> top;

        std::span<const std::byte> nodes() const;
        std::vector<CookedChunkEntry> table() const;
        std::optional<std::vector<CookedPart>> parts() const; ///< empty: the file does not say
        std::span<const std::byte> record() const;
    };
    /// Reads everything except the chunks. Checks that the file is a cooked file of this version and kind, that its
    /// length is right, and that the checksums match. Throws Error{no_input} or Error{bad_data}.
    Opened open(CookedKind kind) const;
    /// Checks that the chunks follow the top without gaps, each with the length `bytes_of(entry, its number)`.
    template <class BytesOf>
    void check_table(const Opened& opened, std::span<const CookedChunkEntry> table, BytesOf bytes_of) const
    {
        std::uint64_t next = sizeof(CookedHeader) + opened.top.size();
        for (std::size_t i = 0; i < table.size(); ++i) {
            if (table[i].offset != next || table[i].bytes != bytes_of(table[i], i)) refuse_entry(i);
            next += table[i].bytes;
        }
        if (next != opened.header.file_bytes) refuse("has chunks that do not fill it");
    }

    /// The bytes of chunk `chunk` of `count`. Throws ChunkFault; later calls for this chunk throw the same error.
    std::vector<std::byte> read(const Handle& handle, const CookedChunkEntry& entry, std::size_t chunk,
                                std::size_t count) const;
    /// Throws if a part is not within the bounds.
    void check_parts(std::span<const CookedPart> parts, const Aabb& bounds) const;
    [[noreturn]] void refuse(const std::string& why) const;
    [[noreturn]] void refuse_entry(std::size_t chunk) const;
    /// Records a chunk's fault. Throws the fault as ChunkFault.
    [[noreturn]] void refuse_chunk(std::size_t chunk, std::size_t count, const std::string& why) const;

    static constexpr std::size_t whole = ~std::size_t{0}; ///< the index under which faults of the file itself are
                                                          ///< recorded
    void note(std::size_t chunk, const std::string& what) const;
    /// Throws the fault that was recorded before, if any.
    void check_known(std::size_t chunk) const;
    /// The faults since the file was opened, one line per chunk.
    std::vector<std::string> faults() const;

private:
    std::string name_;
    std::filesystem::path path_; ///< absolute
    mutable OrderedMutex<LockRank::cooked_file> mutex_;
    mutable std::map<std::size_t, std::string> faults_; ///< by chunk
};

/// The kind of a cooked file, from its header. Throws as CookedFile::open() does.
CookedKind cooked_kind(const std::filesystem::path& path);

/// Removes a value from the front of bytes. The caller must have checked that the bytes suffice.
template <class Value>
Value take(std::span<const std::byte>& bytes)
{
    Value value;
    std::memcpy(&value, bytes.data(), sizeof value);
    bytes = bytes.subspan(sizeof value);
    return value;
}

template <class Value>
void take(std::span<const std::byte>& bytes, std::span<Value> values)
{
    if (values.empty()) return;
    std::memcpy(static_cast<void*>(values.data()), bytes.data(), values.size_bytes());
    bytes = bytes.subspan(values.size_bytes());
}

} // namespace oncollide
