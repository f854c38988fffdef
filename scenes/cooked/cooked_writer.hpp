#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include <oncollide/base/aabb.hpp>
#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/scenes/cooked/cooked_file.hpp>

namespace oncollide {

/// A growing buffer of bytes.
class CookedBytes {
public:
    template <class Value>
    void add(const Value& value)
    {
        add(std::span(&value, 1));
    }
    template <class Value>
    void add(std::span<const Value> values)
    {
        const char* const from = reinterpret_cast<const char*>(values.data());
        bytes_.insert(bytes_.end(), from, from + values.size_bytes());
    }
    void fill_up() { bytes_.resize((bytes_.size() + 7) / 8 * 8); } ///< pads to a multiple of eight bytes
    std::string_view from(std::size_t begin) const { return {bytes_.data() + begin, bytes_.size() - begin}; }
    std::size_t size() const { return bytes_.size(); }
    void reserve(std::size_t size) { bytes_.reserve(size); }

private:
    LargeVector<char> bytes_;
};

/// Builds a cooked file and writes it.
class CookedWriter {
public:
    CookedHeader header{}; ///< the caller fills in the members of its kind; write() fills in the rest
    CookedBytes nodes, parts, record, data;

    void set_bounds(const Aabb& bounds);
    void set_parts(std::span<const CookedPart> of);
    /// Makes a chunk of the data added to `data` since the last chunk.
    void end_chunk(std::uint32_t triangles = 0, std::uint32_t vertices = 0);
    /// Writes to a temporary name, then renames; completes `header`. Throws Error{cannot_write}.
    void write(const std::filesystem::path& path, CookedKind kind);

private:
    std::vector<CookedChunkEntry> table_; ///< offsets from the first
    std::size_t ended_ = 0;
};

} // namespace oncollide
