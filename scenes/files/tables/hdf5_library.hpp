#pragma once
#include <cstdint>
#include <utility>

#include <hdf5.h>

#include <oncollide/scenes/files/common/loaded_library.hpp>

namespace oncollide {

// The functions of HDF5's library that are used to write its files. Private to scenes.

/// Loaded on first use, as GDAL is: linking it would load network libraries in every program.
class Hdf5 {
    const bool shared_; ///< the program had loaded it before
    const LoadedLibrary library_;
    hid_t variable(const char* name) const;

public:
    Hdf5();
#define ONCOLLIDE_HDF5_FUNCTION(name)                                                                                  \
    const decltype(&::name) name = reinterpret_cast<decltype(&::name)>(library_.find(#name))
    ONCOLLIDE_HDF5_FUNCTION(H5open);
    ONCOLLIDE_HDF5_FUNCTION(H5Eset_auto2);
    ONCOLLIDE_HDF5_FUNCTION(H5Fclose);
    ONCOLLIDE_HDF5_FUNCTION(H5Dclose);
    ONCOLLIDE_HDF5_FUNCTION(H5Dget_space);
    ONCOLLIDE_HDF5_FUNCTION(H5Pclose);
    ONCOLLIDE_HDF5_FUNCTION(H5Screate_simple);
    ONCOLLIDE_HDF5_FUNCTION(H5Sselect_hyperslab);
    ONCOLLIDE_HDF5_FUNCTION(H5Sclose);
    ONCOLLIDE_HDF5_FUNCTION(H5Tclose);
    ONCOLLIDE_HDF5_FUNCTION(H5dont_atexit);
    ONCOLLIDE_HDF5_FUNCTION(H5Fcreate);
    ONCOLLIDE_HDF5_FUNCTION(H5Fflush);
    ONCOLLIDE_HDF5_FUNCTION(H5Fstart_swmr_write);
    ONCOLLIDE_HDF5_FUNCTION(H5Pcreate);
    ONCOLLIDE_HDF5_FUNCTION(H5Pset_libver_bounds);
    ONCOLLIDE_HDF5_FUNCTION(H5Pset_chunk);
    ONCOLLIDE_HDF5_FUNCTION(H5Dcreate2);
    ONCOLLIDE_HDF5_FUNCTION(H5Dset_extent);
    ONCOLLIDE_HDF5_FUNCTION(H5Dwrite);
    ONCOLLIDE_HDF5_FUNCTION(H5Dflush);
    ONCOLLIDE_HDF5_FUNCTION(H5Screate);
    ONCOLLIDE_HDF5_FUNCTION(H5Tcreate);
    ONCOLLIDE_HDF5_FUNCTION(H5Tinsert);
    ONCOLLIDE_HDF5_FUNCTION(H5Tenum_create);
    ONCOLLIDE_HDF5_FUNCTION(H5Tenum_insert);
    ONCOLLIDE_HDF5_FUNCTION(H5Tcopy);
    ONCOLLIDE_HDF5_FUNCTION(H5Tset_size);
    ONCOLLIDE_HDF5_FUNCTION(H5Tset_cset);
    ONCOLLIDE_HDF5_FUNCTION(H5Acreate2);
    ONCOLLIDE_HDF5_FUNCTION(H5Awrite);
    ONCOLLIDE_HDF5_FUNCTION(H5Aclose);
#undef ONCOLLIDE_HDF5_FUNCTION
    hid_t native_double = -1, native_uint8 = -1, native_uint32 = -1, native_uint64 = -1, text = -1;
    hid_t file_access = -1, dataset_creation = -1; ///< classes of property lists
};

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

private:
    std::int64_t id_ = -1;
    Close close_ = nullptr;
};

/// Throws Error{usage} if this machine has no HDF5.
const Hdf5& hdf5();

} // namespace oncollide
