#pragma once
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include <oncollide/narrowphase/gl/heap.hpp>
#include <oncollide/narrowphase/gl/walk/walk_layout.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>

namespace oncollide::gl::walk {

/// The OBB trees on the GPU: nodes as the CPU stores them, orders, and the corners of triangles. A tree goes up once,
/// and later only its new nodes do.
class TreeStore {
public:
    explicit TreeStore(std::size_t most_bytes);

    /// As MeshWalks::hold(). Changes wait for upload().
    std::optional<std::uint32_t> hold(const ObbTree& tree, std::uint32_t frame);
    void drop_unused(std::uint32_t frame);
    /// Queues the copies of all changes. Returns their bytes.
    std::size_t upload();
    void bind() const;
    /// Trees that had no room and wait for others to be dropped.
    std::size_t without_room() const { return refused_.size(); }
    std::size_t bytes() const { return words_.bytes() + vertices_.bytes() + trees_.bytes(); }

private:
    struct Held {
        std::uint32_t identity = 0; ///< 0: the slot is free
        std::uint32_t frame = 0;
        std::uint32_t nodes = 0;                ///< of the tree when it was copied last
        std::uint32_t lines = 0;                ///< of nodes that were copied
        std::size_t first = 0, room = 0;        ///< words: nodes
        std::size_t fixed = 0, fixed_count = 0; ///< words: the order, then the corner numbers of triangles
        std::size_t vertices = 0, vertex_count = 0;
    };
    /// Bytes that wait to be copied to a buffer.
    struct Copy {
        const Heap* to; ///< null: the table of trees
        std::size_t from, at, bytes;
    };

    std::uint32_t free_slot();
    bool add(Held& held, const ObbTree& tree);
    bool update(Held& held, const ObbTree& tree);
    void drop(Held& held);
    void put(const Heap* to, std::size_t byte, const void* data, std::size_t bytes);
    void put_words(std::size_t first, const void* data, std::size_t words) { put(&words_, 4 * first, data, 4 * words); }

    std::size_t most_;
    Heap words_, vertices_;
    Buffer trees_;
    std::vector<GpuTree> table_; ///< by slot
    std::vector<Held> held_;     ///< by slot
    std::vector<std::uint32_t> free_;
    std::unordered_map<std::uint32_t, std::uint32_t> slots_; ///< by ObbTree::identity()
    std::unordered_set<std::uint32_t> refused_;              ///< identities
    std::vector<std::byte> staged_;
    std::vector<Copy> copies_;
    TreeGrowth growth_;
};

} // namespace oncollide::gl::walk
