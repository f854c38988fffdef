#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <oncollide/scenes/files/hdf5/hdf5_dataset.hpp>

namespace oncollide {

// The part of HDF5 that tables need. It reads files without HDF5's library, which damaged files can crash. Private to
// scenes.

/// A dataset of numbers, whose first dimension counts rows. Its data stays in the file.
class Hdf5Column {
public:
    std::uint64_t rows() const { return data_.extent()[0]; }
    std::uint64_t extent(std::size_t dimension) const { return data_.extent()[dimension]; }
    /// Rows `first` to `first + count - 1`. Throws Error{bad_data} if they cannot be read.
    void read(std::uint64_t first, std::uint64_t count, double* out) const;
    void read(std::uint64_t first, std::uint64_t count, std::int64_t* out) const; ///< integers
    /// Within one row: `first` to `first + count - 1` along the second dimension.
    void read_within(std::uint64_t row, std::uint64_t first, std::uint64_t count, double* out) const;

private:
    friend class Hdf5File;
    Hdf5Column(std::string place, Hdf5Dataset data) : place_(std::move(place)), data_(std::move(data)) {}
    template <class Number>
    void read(const std::vector<std::uint64_t>& start, const std::vector<std::uint64_t>& count, Number* out) const;

    std::string place_; ///< file and dataset, for errors
    Hdf5Dataset data_;
};

/// A file open for reading. Throws Error{bad_data} prefixed with the file's name, and Error{no_input} for a missing
/// file.
class Hdf5File {
public:
    explicit Hdf5File(const std::filesystem::path& path);

    /// The names in a group, sorted.
    std::vector<std::string> names_in(const std::string& group) const;
    enum class Numbers { real, whole };
    /// The dataset of that path, whose rows have these extents: empty for one number per row; 0: any extent. Throws if
    /// it has another shape or type, or is in another file.
    Hdf5Column column(const std::string& path, Numbers numbers, const std::vector<std::uint64_t>& row) const;

private:
    std::string name_;
    std::shared_ptr<const Hdf5Bytes> file_;
};

} // namespace oncollide
