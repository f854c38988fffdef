#pragma once
#include <cstdint>

#include <hdf5.h>

#include <oncollide/scenes/files/loaded_library.hpp>

namespace oncollide {

// The functions of HDF5's library that are used to read and write its files. Private to scenes.

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
    ONCOLLIDE_HDF5_FUNCTION(H5Fopen);
    ONCOLLIDE_HDF5_FUNCTION(H5Fclose);
    ONCOLLIDE_HDF5_FUNCTION(H5Gopen2);
    ONCOLLIDE_HDF5_FUNCTION(H5Gclose);
    ONCOLLIDE_HDF5_FUNCTION(H5Gget_info);
    ONCOLLIDE_HDF5_FUNCTION(H5Lget_name_by_idx);
    ONCOLLIDE_HDF5_FUNCTION(H5Dopen2);
    ONCOLLIDE_HDF5_FUNCTION(H5Dclose);
    ONCOLLIDE_HDF5_FUNCTION(H5Dget_storage_size);
    ONCOLLIDE_HDF5_FUNCTION(H5Dget_type);
    ONCOLLIDE_HDF5_FUNCTION(H5Dget_space);
    ONCOLLIDE_HDF5_FUNCTION(H5Dget_create_plist);
    ONCOLLIDE_HDF5_FUNCTION(H5Dread);
    ONCOLLIDE_HDF5_FUNCTION(H5Pget_layout);
    ONCOLLIDE_HDF5_FUNCTION(H5Pget_chunk);
    ONCOLLIDE_HDF5_FUNCTION(H5Pget_external_count);
    ONCOLLIDE_HDF5_FUNCTION(H5Pset_elink_cb);
    ONCOLLIDE_HDF5_FUNCTION(H5Pclose);
    ONCOLLIDE_HDF5_FUNCTION(H5Screate_simple);
    ONCOLLIDE_HDF5_FUNCTION(H5Sget_simple_extent_ndims);
    ONCOLLIDE_HDF5_FUNCTION(H5Sget_simple_extent_dims);
    ONCOLLIDE_HDF5_FUNCTION(H5Sselect_hyperslab);
    ONCOLLIDE_HDF5_FUNCTION(H5Sclose);
    ONCOLLIDE_HDF5_FUNCTION(H5Tget_class);
    ONCOLLIDE_HDF5_FUNCTION(H5Tget_size);
    ONCOLLIDE_HDF5_FUNCTION(H5Tclose);
    ONCOLLIDE_HDF5_FUNCTION(H5dont_atexit);
    ONCOLLIDE_HDF5_FUNCTION(H5free_memory);
    ONCOLLIDE_HDF5_FUNCTION(H5Fcreate);
    ONCOLLIDE_HDF5_FUNCTION(H5Fflush);
    ONCOLLIDE_HDF5_FUNCTION(H5Fstart_swmr_write);
    ONCOLLIDE_HDF5_FUNCTION(H5Pcreate);
    ONCOLLIDE_HDF5_FUNCTION(H5Pset_libver_bounds);
    ONCOLLIDE_HDF5_FUNCTION(H5Pset_chunk);
    ONCOLLIDE_HDF5_FUNCTION(H5Pset_metadata_read_attempts);
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
    ONCOLLIDE_HDF5_FUNCTION(H5Aopen);
    ONCOLLIDE_HDF5_FUNCTION(H5Awrite);
    ONCOLLIDE_HDF5_FUNCTION(H5Aread);
    ONCOLLIDE_HDF5_FUNCTION(H5Aclose);
#undef ONCOLLIDE_HDF5_FUNCTION
    hid_t native_double = -1, native_int64 = -1, native_uint8 = -1, native_uint32 = -1, native_uint64 = -1, text = -1;
    hid_t file_access = -1, dataset_creation = -1, dataset_access = -1,
          group_access = -1; ///< classes of property lists
};

/// Throws Error{usage} if this machine has no HDF5.
const Hdf5& hdf5();

} // namespace oncollide
