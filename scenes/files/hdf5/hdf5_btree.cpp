#include <oncollide/scenes/files/hdf5/hdf5_btree.hpp>

#include <bit>
#include <limits>
#include <vector>

namespace oncollide {

namespace {

constexpr unsigned most_levels = 32;

using VisitChild = FunctionRef<void(Hdf5Cursor key, std::uint64_t child)>;

struct OldTree {
    Hdf5Walk& walk;
    unsigned type, key_bytes;
    VisitChild visit;

    /// @param level  the level of the node; leaves have level 0
    void node(std::uint64_t address, unsigned level)
    {
        const unsigned fixed = 8 + 2 * walk.file.offset_bytes();
        const Hdf5Block prefix = walk.block(address, fixed);
        Hdf5Cursor cursor = prefix.cursor(walk.file);
        cursor.expect("TREE");
        if (cursor.u8() != type) cursor.damaged("a B-tree of another type");
        if (cursor.u8() != level) cursor.damaged("a B-tree has nodes of other levels");
        const std::uint64_t children = cursor.u16();
        const Hdf5Block block =
            walk.block(address + fixed, children * (key_bytes + walk.file.offset_bytes()) + key_bytes);
        Hdf5Cursor entries = block.cursor(walk.file);
        for (std::uint64_t i = 0; i < children; ++i) {
            const Hdf5Cursor key = entries.part(key_bytes);
            const std::uint64_t child = entries.address();
            if (level > 0)
                node(child, level - 1);
            else
                visit(key, child);
        }
    }
};

/// Bytes that store numbers up to `most`.
unsigned bytes_for(std::uint64_t most)
{
    return (static_cast<unsigned>(std::bit_width(most)) + 7) / 8;
}

struct NewTree {
    Hdf5Walk& walk;
    unsigned type;
    std::uint64_t record_bytes, node_bytes;
    FunctionRef<void(Hdf5Cursor)> visit;
    unsigned count_bytes = 0;                ///< bytes of the number of records in a child
    std::vector<unsigned> all_count_bytes{}; ///< by level: bytes of the number of records below a node

    /// The sizes of the fields of nodes follow from the largest possible numbers.
    void measure(unsigned depth)
    {
        constexpr std::uint64_t fixed = 10;
        constexpr double largest = static_cast<double>(std::numeric_limits<std::uint64_t>::max());
        const std::uint64_t in_leaf = (node_bytes - fixed) / record_bytes;
        std::uint64_t all = in_leaf;
        count_bytes = bytes_for(in_leaf), all_count_bytes = {0};
        for (unsigned level = 1; level <= depth; ++level) {
            const std::uint64_t pointer = walk.file.offset_bytes() + count_bytes + all_count_bytes.back();
            if (node_bytes < fixed + pointer) hdf5_damaged(0, "the nodes of a B-tree are too short");
            const std::uint64_t here = (node_bytes - fixed - pointer) / (record_bytes + pointer);
            const double estimate = (static_cast<double>(here) + 1) * static_cast<double>(all);
            all = estimate < largest / 2 ? (here + 1) * all + here : ~std::uint64_t{0};
            all_count_bytes.push_back(bytes_for(all));
        }
    }

    void node(std::uint64_t address, std::uint64_t records, unsigned level)
    {
        constexpr std::uint64_t prefix = 6, checksum = 4;
        const unsigned below = level > 0 ? all_count_bytes[level - 1] : 0;
        const std::uint64_t pointers = level > 0 ? (records + 1) * (walk.file.offset_bytes() + count_bytes + below) : 0;
        if (prefix + records * record_bytes + pointers + checksum > node_bytes)
            hdf5_damaged(address, "a B-tree's node has too many records");
        const Hdf5Block block = walk.checked(address, prefix + records * record_bytes + pointers + checksum);
        Hdf5Cursor cursor = block.cursor(walk.file);
        cursor.expect(level > 0 ? "BTIN" : "BTLF", 0);
        if (cursor.u8() != type) cursor.damaged("a B-tree has nodes of another type");
        for (std::uint64_t i = 0; i < records; ++i) visit(cursor.part(record_bytes));
        for (std::uint64_t i = 0; level > 0 && i <= records; ++i) {
            const std::uint64_t child = cursor.address(), in_child = cursor.number(count_bytes);
            cursor.skip(below);
            node(child, in_child, level - 1);
        }
    }
};

} // namespace

void walk_old_btree(Hdf5Walk& walk, std::uint64_t root, unsigned type, unsigned key_bytes, VisitChild visit)
{
    const unsigned level = walk.block(root, 6).cursor(walk.file).part(6).take(6)[5];
    if (level >= most_levels) hdf5_damaged(root, "a B-tree is too deep");
    OldTree{walk, type, key_bytes, visit}.node(root, level);
}

void walk_btree(Hdf5Walk& walk, std::uint64_t header, unsigned type, unsigned other_type,
                FunctionRef<void(Hdf5Cursor record)> visit)
{
    const unsigned bytes = 22 + walk.file.offset_bytes() + walk.file.length_bytes();
    const Hdf5Block block = walk.checked(header, bytes);
    Hdf5Cursor cursor = block.cursor(walk.file);
    cursor.expect("BTHD", 0);
    const unsigned found = cursor.u8();
    if (found != type && found != other_type) cursor.damaged("a B-tree of another type");
    const std::uint64_t node_bytes = cursor.u32(), record_bytes = cursor.u16();
    const unsigned depth = cursor.u16();
    cursor.skip(2);
    const std::uint64_t root = cursor.address(), records = cursor.u16();
    if (depth >= most_levels || record_bytes == 0 || node_bytes < 10 + record_bytes)
        cursor.damaged("a B-tree has impossible sizes");
    if (root == hdf5_nowhere || records == 0) return;
    NewTree tree{walk, found, record_bytes, node_bytes, visit};
    tree.measure(depth);
    tree.node(root, records, depth);
}

} // namespace oncollide
