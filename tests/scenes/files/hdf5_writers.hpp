#pragma once
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <hdf5.h>

namespace oncollide::test {

// HDF5 files of all layouts, written by HDF5's library.

struct Hdf5Plan {
    const char* name;
    std::vector<hsize_t> extent;
    std::vector<hsize_t> chunk = {}; ///< empty: contiguous
    std::vector<hsize_t> most = {};  ///< of the extent; empty: the same
    bool compact = false, early = false, shuffle = false, deflate = false, fletcher = false;
    bool parts_unfiltered = false; ///< chunks that are partly outside
    enum { nothing, some, all } written = all;
};

inline std::vector<Hdf5Plan> hdf5_plans()
{
    constexpr hsize_t any = H5S_UNLIMITED;
    const auto some = Hdf5Plan::some;
    return {
        {"contiguous", {23, 3}},
        {.name = "nothing", .extent = {23, 3}, .written = Hdf5Plan::nothing},
        {.name = "compact", .extent = {23, 3}, .compact = true},
        {"chunks", {23, 3}, {4, 2}},
        {.name = "some", .extent = {23, 3}, .chunk = {4, 2}, .written = some},
        {.name = "packed", .extent = {23, 3}, .chunk = {4, 3}, .shuffle = true, .deflate = true},
        {.name = "deflated", .extent = {23, 3}, .chunk = {5, 2}, .deflate = true, .written = some},
        {.name = "checked", .extent = {23, 3}, .chunk = {4, 2}, .shuffle = true, .deflate = true, .fletcher = true},
        {.name = "fletcher", .extent = {23, 3}, .chunk = {4, 2}, .fletcher = true},
        {.name = "single", .extent = {23, 3}, .chunk = {23, 3}},
        {.name = "single packed", .extent = {23, 3}, .chunk = {23, 3}, .shuffle = true, .deflate = true},
        {.name = "implicit", .extent = {23, 3}, .chunk = {4, 2}, .most = {40, 5}, .early = true},
        {.name = "fixed", .extent = {23, 3}, .chunk = {4, 2}, .most = {40, 5}, .written = some},
        {.name = "growing", .extent = {23, 3}, .chunk = {1, 2}, .most = {any, 3}},
        {.name = "growing packed",
         .extent = {23, 3},
         .chunk = {1, 3},
         .most = {any, 3},
         .shuffle = true,
         .deflate = true},
        {.name = "growing rows", .extent = {3, 23}, .chunk = {2, 1}, .most = {5, any}, .written = some},
        {.name = "growing both ways", .extent = {23, 3}, .chunk = {2, 1}, .most = {any, any}},
        {.name = "both ways packed",
         .extent = {23, 3},
         .chunk = {2, 2},
         .most = {any, any},
         .deflate = true,
         .written = some},
        {.name = "parts", .extent = {23, 3}, .chunk = {4, 2}, .deflate = true, .parts_unfiltered = true},
        {.name = "one number per row", .extent = {57}, .chunk = {10}, .most = {any}, .deflate = true},
        {.name = "frames", .extent = {3, 5, 7}, .chunk = {1, 5, 7}, .most = {any, 5, 7}},
        {.name = "boxes",
         .extent = {5, 6, 7},
         .chunk = {2, 3, 4},
         .most = {5, any, any},
         .shuffle = true,
         .deflate = true},
        {.name = "empty", .extent = {0, 3}, .chunk = {4, 3}, .most = {any, 3}},
    };
}

/// Writes a dataset of random bytes.
inline void write_hdf5(hid_t place, const char* name, const Hdf5Plan& plan, hid_t type, std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    const int n = static_cast<int>(plan.extent.size());
    const hid_t space = H5Screate_simple(n, plan.extent.data(), plan.most.empty() ? nullptr : plan.most.data()),
                create = H5Pcreate(H5P_DATASET_CREATE);
    if (!plan.chunk.empty()) H5Pset_chunk(create, n, plan.chunk.data());
    if (plan.compact) H5Pset_layout(create, H5D_COMPACT);
    if (plan.early) H5Pset_alloc_time(create, H5D_ALLOC_TIME_EARLY);
    if (plan.shuffle) H5Pset_shuffle(create);
    if (plan.deflate) H5Pset_deflate(create, 6);
    if (plan.fletcher) H5Pset_fletcher32(create);
    if (plan.parts_unfiltered) H5Pset_chunk_opts(create, H5D_CHUNK_DONT_FILTER_PARTIAL_CHUNKS);
    const std::size_t bytes = H5Tget_size(type);
    std::string fill(bytes, '\0');
    for (char& c : fill) c = static_cast<char>(random());
    if (seed % 2) H5Pset_fill_value(create, type, fill.data());
    const hid_t data = H5Dcreate2(place, name, type, space, H5P_DEFAULT, create, H5P_DEFAULT);
    std::vector<hsize_t> start(plan.extent.size(), 0), count = plan.extent;
    if (plan.written == Hdf5Plan::some)
        start[0] = 15 * count[0] / 16, count[0] = std::clamp<hsize_t>(count[0] / 16, 1, 2000);
    hsize_t values = plan.written == Hdf5Plan::nothing ? 0 : 1;
    for (const hsize_t edge : count) values *= edge;
    std::string content(values * bytes, '\0');
    // Few different numbers, so that they can be packed, and all exponents of real numbers.
    for (std::size_t i = 0; i < content.size(); ++i)
        content[i] = static_cast<char>(random() % 5 ? random() : random() % 2);
    if (values > 0) {
        const hid_t memory = H5Screate_simple(n, count.data(), nullptr);
        H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
        H5Dwrite(data, type, memory, space, H5P_DEFAULT, content.data());
        H5Sclose(memory);
    }
    H5Dclose(data), H5Pclose(create), H5Sclose(space);
}

constexpr H5F_libver_t hdf5_oldest = H5F_LIBVER_EARLIEST, hdf5_newest = H5F_LIBVER_LATEST;

/// A new file.
/// @param version  the oldest version of HDF5 that can read it
inline hid_t create_hdf5(const std::filesystem::path& path, H5F_libver_t version, hsize_t user_block = 0)
{
    const hid_t create = H5Pcreate(H5P_FILE_CREATE), access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_userblock(create, user_block);
    H5Pset_libver_bounds(access, version, H5F_LIBVER_LATEST);
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, create, access);
    H5Pclose(create), H5Pclose(access);
    return file;
}

inline hid_t hdf5_half()
{
    const hid_t half = H5Tcopy(H5T_IEEE_F32LE);
    H5Tset_fields(half, 15, 10, 5, 0, 10), H5Tset_size(half, 2), H5Tset_ebias(half, 15);
    return half;
}

} // namespace oncollide::test
