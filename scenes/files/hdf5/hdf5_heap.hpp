#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <oncollide/scenes/files/hdf5/hdf5_bytes.hpp>

namespace oncollide {

// The three kinds of heaps of HDF5 files. Private to scenes.

/// The texts of a group with a symbol table.
class Hdf5LocalHeap {
public:
    Hdf5LocalHeap(Hdf5Walk& walk, std::uint64_t address);
    std::string_view text(std::uint64_t offset) const;

private:
    Hdf5Block data_;
};

/// Links or attributes of objects that have many of them.
class Hdf5FractalHeap {
public:
    Hdf5FractalHeap(Hdf5Walk& walk, std::uint64_t address);
    /// @param id  the id of the object
    Hdf5Block object(Hdf5Cursor id);

private:
    /// Part of the heap: a block with objects, or a table of such parts.
    struct Place {
        std::uint64_t address, first; ///< first: offset in the heap
        std::uint64_t size;           ///< size of a block with objects; 0: a table
        unsigned rows;                ///< number of rows of a table
    };
    Place child(const Place& table, std::uint64_t offset);
    std::uint64_t row_bytes(unsigned row) const; ///< the size of each block in a row
    const Hdf5Block& read(const Place& place);

    Hdf5Walk& walk_;
    std::uint64_t width_ = 0, start_bytes_ = 0, most_direct_bytes_ = 0;
    unsigned offset_bits_ = 0, size_bytes_ = 0; ///< sizes of ids
    bool is_checked_ = false;                   ///< blocks with objects have checksums
    Place root_{};
    std::map<std::uint64_t, Hdf5Block> blocks_; ///< by address
};

/// Texts of variable length. Reads each collection of texts once.
class Hdf5TextHeap {
public:
    explicit Hdf5TextHeap(const Hdf5Bytes& file) : walk_(file) {}
    /// @param place  the length of the text, and its place
    std::string_view text(Hdf5Cursor place);

private:
    struct Collection {
        Hdf5Block block;
        std::vector<std::pair<unsigned, std::string_view>> objects; ///< sorted by number
    };
    const Collection& collection(std::uint64_t address);

    Hdf5Walk walk_;
    std::map<std::uint64_t, Collection> collections_;
};

} // namespace oncollide
