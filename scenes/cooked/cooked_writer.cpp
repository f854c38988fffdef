#include <oncollide/scenes/cooked/cooked_writer.hpp>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/checksum.hpp>
#include <oncollide/base/files/output_file.hpp>

namespace oncollide {

void CookedWriter::set_bounds(const Aabb& bounds)
{
    ONCOLLIDE_ASSERT(!bounds.empty());
    std::memcpy(header.low, bounds.min.data(), sizeof header.low);
    std::memcpy(header.high, bounds.max.data(), sizeof header.high);
}

void CookedWriter::set_parts(std::span<const CookedPart> of)
{
    header.parts_known = 1;
    parts.add(of);
}

void CookedWriter::end_chunk(std::uint32_t triangles, std::uint32_t vertices)
{
    data.fill_up();
    ONCOLLIDE_ASSERT(ended_ <= data.size());
    table_.push_back({ended_, data.size() - ended_, checksum(data.from(ended_)), triangles, vertices});
    ended_ = data.size();
}

void CookedWriter::write(const std::filesystem::path& path, CookedKind kind)
{
    std::memcpy(header.magic, cooked_magic, sizeof cooked_magic);
    header.byte_order = cooked_byte_order, header.version = cooked_version, header.kind = kind;
    header.nodes = static_cast<std::uint32_t>(nodes.size() / cooked_node_bytes(kind));
    header.chunks = static_cast<std::uint32_t>(table_.size());
    header.parts = parts.size() / cooked_part_bytes;
    const std::uint64_t first =
        sizeof header + nodes.size() + table_.size() * sizeof(CookedChunkEntry) + parts.size() + record.size();
    for (CookedChunkEntry& entry : table_) entry.offset += first, nodes.add(entry);
    nodes.add(std::span<const char>(parts.from(0))), nodes.add(std::span<const char>(record.from(0)));
    header.top_checksum = checksum(nodes.from(0));
    header.file_bytes = first + data.size();
    const std::string_view bytes(reinterpret_cast<const char*>(&header), sizeof header);
    header.header_checksum = checksum(bytes.substr(0, offsetof(CookedHeader, header_checksum)));
    OutputFile file(path);
    file.write(bytes), file.write(nodes.from(0)), file.write(data.from(0));
    file.commit();
}

} // namespace oncollide
