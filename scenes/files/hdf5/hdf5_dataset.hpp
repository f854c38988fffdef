#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_chunks.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_type.hpp>

namespace oncollide {

/// Values in memory: `rows` times `columns` values at steps of bytes, and where they belong in the result.
struct Hdf5Piece {
    const char* from;
    std::uint64_t rows, columns, row_bytes;
    std::uint64_t value_bytes; ///< step between columns; 0: all are the same value
    std::uint64_t to, to_row;  ///< numbers of values in the result; columns follow each other
};

/// A dataset of any layout. Its data stays in the file. Not thread-safe.
class Hdf5Dataset {
public:
    /// Throws Hdf5Fault if the object is not a dataset, or uses a feature that is not read.
    Hdf5Dataset(std::shared_ptr<const Hdf5Bytes> file, const Hdf5Object& object);

    const Hdf5Type& type() const { return type_; }
    const std::vector<std::uint64_t>& extent() const { return space_.extent; }
    /// The number of rows for which the file has enough bytes; the other rows were never written.
    std::uint64_t rows_in_file() const;
    /// Calls take(piece) until the values from `start`, `count` in each dimension, are complete. They must exist.
    void read(std::span<const std::uint64_t> start, std::span<const std::uint64_t> count,
              FunctionRef<void(const Hdf5Piece&)> take) const;
    const Hdf5Bytes& file() const { return *file_; }

private:
    struct Slot {
        std::uint64_t number = hdf5_nowhere;
        std::string bytes;
    };
    void place_contiguous(const Hdf5Object& object);
    const char* load(std::uint64_t number, std::span<const std::uint64_t> chunk) const; ///< null: not written
    void read_contiguous(std::span<const std::uint64_t> chunk, std::string& out) const;
    void read_chunk(const Hdf5Chunk& chunk, bool is_part, std::string& out) const;
    void give(std::span<const std::uint64_t> chunk, std::span<const std::uint64_t> start,
              std::span<const std::uint64_t> count, FunctionRef<void(const Hdf5Piece&)> take) const;

    std::shared_ptr<const Hdf5Bytes> file_;
    Hdf5Type type_;
    Hdf5Space space_;
    Hdf5Layout layout_; ///< all layouts have edges here: contiguous data is cut into chunks
    std::string fill_;
    std::uint64_t chunk_bytes_ = 0;
    std::unique_ptr<Hdf5Grid> grid_;
    std::vector<Hdf5Chunk> chunks_;
    mutable std::vector<Slot> slots_; ///< chunks in memory: as many as lie next to each other in the first rows
    mutable std::string stored_;
};

/// Reads numbers as doubles (whole or real ones) or integers (whole ones, limited to the range).
void read_hdf5_numbers(const Hdf5Dataset& dataset, std::span<const std::uint64_t> start,
                       std::span<const std::uint64_t> count, double* out);
void read_hdf5_numbers(const Hdf5Dataset& dataset, std::span<const std::uint64_t> start,
                       std::span<const std::uint64_t> count, std::int64_t* out);

} // namespace oncollide
