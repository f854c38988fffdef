#include <oncollide/scenes/files/tables/hdf5_library.hpp>

#include <dlfcn.h>

namespace oncollide {

/// In a program that is linked with HDF5, the library uses the program's copies of its variables.
hid_t Hdf5::variable(const char* name) const
{
    const void* const linked = ::dlsym(RTLD_DEFAULT, name);
    return *static_cast<const hid_t*>(linked ? linked : library_.find(name));
}

Hdf5::Hdf5()
    : shared_(::dlopen(ONCOLLIDE_HDF5_LIBRARY, RTLD_NOW | RTLD_NOLOAD)),
      library_(ONCOLLIDE_HDF5_LIBRARY, "writes HDF5 files", "libhdf5-103-1")
{
    if (!shared_) H5dont_atexit(); // otherwise HDF5 would try again at exit to write a file that could not be written
    H5open();
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); // otherwise HDF5 prints its errors
    native_double = variable("H5T_NATIVE_DOUBLE_g"), native_uint8 = variable("H5T_NATIVE_UINT8_g"),
    native_uint32 = variable("H5T_NATIVE_UINT32_g");
    native_uint64 = variable("H5T_NATIVE_UINT64_g"), text = variable("H5T_C_S1_g");
    file_access = variable("H5P_CLS_FILE_ACCESS_ID_g"), dataset_creation = variable("H5P_CLS_DATASET_CREATE_ID_g");
}

const Hdf5& hdf5()
{
    static const Hdf5 library;
    return library;
}

} // namespace oncollide
