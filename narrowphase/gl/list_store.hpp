#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/narrowphase/gl/resources.hpp>
#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>

namespace oncollide::gl {

/// Makes `buffer` at least `bytes` large, keeping its first `kept` bytes. Throws GpuLost if that is over `most`; `what`
/// names the content. Without flags only the GPU can write to it, so it stays in the GPU's own memory.
void grow(Buffer& buffer, std::size_t bytes, std::size_t kept, std::size_t most, const char* what,
          GLbitfield flags = 0);

/// Triangle lists on the GPU: entries (4 bytes per triangle and octant), and where each list's octants begin (36 bytes
/// per list). The CPU knows which lists exist, but not their lengths. Released lists leave holes, which packing
/// removes.
class ListStore {
public:
    ListStore(std::size_t most_bytes, std::size_t first_entries);

    ListId add();
    void release(ListId list);
    /// Makes room for all existing lists, before a batch writes them.
    void make_list_room();
    /// Makes room for `count` more entries: by packing if that may help, else by a larger buffer.
    void make_entry_room(std::size_t count);

    void bind() const;
    std::size_t entry_room() const { return entries_.bytes() / 4; }
    std::size_t entries() const { return used_; }
    /// Ends a batch: its lists count from now on.
    void commit(std::size_t entries) { used_ = entries, fresh_.clear(); }
    /// Reads the triangles of each read, packed, each sorted.
    void read(std::span<const ListRead> reads, std::vector<std::uint32_t>& triangles, std::vector<std::size_t>& ends);
    std::size_t bytes() const { return 4 * used_ + 36 * (lists_in_use_.size() - free_.size()); }

private:
    void pack();
    void run_jobs(const Program& program, std::span<const std::uint32_t> jobs, const Buffer& target);

    std::size_t most_;
    Buffer entries_, lists_, jobs_, counters_, packed_;
    std::size_t used_ = 0;            ///< entries, holes included
    bool holes_ = false;              ///< lists were released since the last packing
    std::vector<bool> lists_in_use_;  ///< by list
    std::vector<std::uint32_t> free_; ///< released list numbers
    std::vector<ListId> fresh_;       ///< lists of the current batch, which must not be packed
    Program pack_, read_;
};

} // namespace oncollide::gl
