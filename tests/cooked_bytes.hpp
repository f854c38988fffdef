#pragma once
#include <cstddef>
#include <cstring>
#include <string>

#include <oncollide/base/files/checksum.hpp>
#include <oncollide/scenes/cooked/cooked_format.hpp>

namespace oncollide::test {

template <class Value>
Value value_at(const std::string& bytes, std::size_t at)
{
    Value value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}
template <class Value>
void set_value(std::string& bytes, std::size_t at, const Value& value)
{
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// Offset of the table of chunks in a cooked file.
inline std::size_t table_of(const std::string& bytes)
{
    const auto header = value_at<CookedHeader>(bytes, 0);
    return sizeof header + std::size_t(header.nodes) * cooked_node_bytes(header.kind);
}

inline CookedChunkEntry chunk_at(const std::string& bytes, std::size_t chunk)
{
    return value_at<CookedChunkEntry>(bytes, table_of(bytes) + chunk * sizeof(CookedChunkEntry));
}

/// Recomputes the checksums of a modified cooked file. Bytes without room for checksums are returned unchanged.
inline std::string resealed(std::string bytes)
{
    if (bytes.size() < sizeof(CookedHeader)) return bytes;
    const auto header = value_at<CookedHeader>(bytes, 0);
    const std::size_t table = table_of(bytes);
    const std::size_t end = table + header.chunks * sizeof(CookedChunkEntry) +
                            (header.parts < bytes.size() ? header.parts : 0) * cooked_part_bytes +
                            cooked_record_bytes(header.kind);
    if (table <= bytes.size() && header.chunks <= bytes.size())
        for (std::size_t c = 0; c < header.chunks && end <= bytes.size(); ++c) {
            const std::size_t at = table + c * sizeof(CookedChunkEntry);
            auto entry = value_at<CookedChunkEntry>(bytes, at);
            if (entry.offset > bytes.size() || entry.bytes > bytes.size() - entry.offset) continue;
            entry.checksum = checksum(std::string_view(bytes).substr(entry.offset, entry.bytes));
            set_value(bytes, at, entry);
        }
    if (end <= bytes.size())
        set_value(bytes, offsetof(CookedHeader, top_checksum),
                  checksum(std::string_view(bytes).substr(sizeof header, end - sizeof header)));
    set_value(bytes, offsetof(CookedHeader, header_checksum),
              checksum(std::string_view(bytes).substr(0, offsetof(CookedHeader, header_checksum))));
    return bytes;
}

} // namespace oncollide::test
