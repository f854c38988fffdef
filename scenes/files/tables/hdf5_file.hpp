#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace oncollide {

// The part of HDF5 that tables need; the only user of the library for reading tables. Private to scenes.

/// An open object of HDF5, closed by the destructor.
class Hdf5Handle {
public:
    using Close = int (*)(std::int64_t);
    Hdf5Handle() = default;
    Hdf5Handle(std::int64_t id, Close close) : id_(id), close_(close) {}
    Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Hdf5Handle& operator=(Hdf5Handle&& other) noexcept
    {
        std::swap(id_, other.id_), std::swap(close_, other.close_);
        return *this;
    }
    ~Hdf5Handle()
    {
        if (id_ >= 0) close_(id_);
    }
    std::int64_t id() const { return id_; }
    bool valid() const { return id_ >= 0; }

private:
    std::int64_t id_ = -1;
    Close close_ = nullptr;
};

/// Opens a group or a dataset of a file; invalid if there is none. No other file is opened: throws Error{bad_data} for
/// external links, external storage and virtual datasets, which could name any file or a pipe.
/// @param place  for errors
Hdf5Handle open_group(std::int64_t file, const std::string& path, const std::string& place);
Hdf5Handle open_dataset(std::int64_t file, const std::string& path, const std::string& place);

/// A dataset of numbers, whose first dimension counts rows. Its data stays in the file.
class Hdf5Column {
public:
    std::uint64_t rows() const { return extent_[0]; }
    std::uint64_t extent(std::size_t dimension) const { return extent_[dimension]; }
    /// Rows `first` to `first + count - 1`, converted by HDF5. Throws Error{bad_data} if they cannot be read.
    void read(std::uint64_t first, std::uint64_t count, double* out) const;
    void read(std::uint64_t first, std::uint64_t count, std::int64_t* out) const; ///< integers
    /// Within one row: `first` to `first + count - 1` along the second dimension.
    void read_within(std::uint64_t row, std::uint64_t first, std::uint64_t count, double* out) const;

private:
    friend class Hdf5File;
    void read(const std::vector<unsigned long long>& start, const std::vector<unsigned long long>& extent,
              std::int64_t type, void* out) const;
    void read(std::uint64_t first, std::uint64_t count, std::int64_t type, void* out) const;

    std::string place_; ///< file and dataset, for errors
    Hdf5Handle dataset_, space_;
    std::vector<unsigned long long> extent_;
};

/// A file open for reading. Throws Error{bad_data} prefixed with the file's name, Error{no_input} for a missing file,
/// and Error{usage} if this build or this machine has no HDF5.
class Hdf5File {
public:
    explicit Hdf5File(const std::filesystem::path& path);

    /// The names in a group.
    std::vector<std::string> names_in(const std::string& group) const;
    enum class Numbers { real, whole };
    /// The dataset of that path, whose rows have these extents: empty for one number per row; 0: any extent. Throws if
    /// it has another shape or type.
    Hdf5Column column(const std::string& path, Numbers numbers, const std::vector<std::uint64_t>& row) const;

private:
    std::string name_;
    Hdf5Handle file_;
};

} // namespace oncollide
