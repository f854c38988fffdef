#pragma once
#include <filesystem>

#include <oncollide/scenes/files/tables/hdf5_library.hpp>

namespace oncollide::hdf5_writing {

// Objects of HDF5's library that writers make. Private to scenes.

/// Throws Failed if the library returned a failure.
struct Failed {};
template <class Result>
Result sure(Result result)
{
    if (result < 0) throw Failed{};
    return result;
}

inline Hdf5Handle type(hid_t id)
{
    return {sure(id), hdf5().H5Tclose};
}
inline Hdf5Handle space(hid_t id)
{
    return {sure(id), hdf5().H5Sclose};
}
inline Hdf5Handle properties(hid_t kind)
{
    return {sure(hdf5().H5Pcreate(kind)), hdf5().H5Pclose};
}

/// A new file in place of one that exists.
inline Hdf5Handle create(const std::filesystem::path& path)
{
    constexpr unsigned truncate = 2; // H5F_ACC_TRUNC, a macro that calls a function
    const Hdf5& h5 = hdf5();
    const Hdf5Handle access = properties(h5.file_access);
    sure(h5.H5Pset_libver_bounds(access.id(), H5F_LIBVER_V110, H5F_LIBVER_V110)); // required by SWMR
    return {sure(h5.H5Fcreate(path.c_str(), truncate, H5P_DEFAULT, access.id())), h5.H5Fclose};
}

} // namespace oncollide::hdf5_writing
