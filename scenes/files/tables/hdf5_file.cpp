#include <oncollide/scenes/files/tables/hdf5_file.hpp>

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/tables/hdf5_library.hpp>

namespace oncollide {

namespace {

constexpr unsigned read_only = 0; // H5F_ACC_RDONLY is a macro that calls a function of the library

/// Refuses chunks that are so large that one fills the memory.
void check_chunks(const std::string& place, hid_t dataset, int dimensions, std::size_t number_bytes)
{
    constexpr std::uint64_t most_bytes = std::uint64_t{256} << 20;
    const Hdf5& h5 = hdf5();
    const Hdf5Handle plan(h5.H5Dget_create_plist(dataset), h5.H5Pclose);
    if (!plan.valid() || h5.H5Pget_layout(plan.id()) != H5D_CHUNKED) return;
    std::vector<hsize_t> edges(static_cast<std::size_t>(dimensions));
    double bytes = static_cast<double>(number_bytes);
    if (h5.H5Pget_chunk(plan.id(), dimensions, edges.data()) != dimensions) bytes = 1e300;
    for (const hsize_t edge : edges) bytes *= static_cast<double>(edge);
    if (bytes > static_cast<double>(most_bytes))
        refuse(place, fmt::format("its chunks are larger than {} bytes", most_bytes));
}

constexpr const char* in_other_file =
    "is a link to another file, or has its data there; everything must be in one file";

/// HDF5 calls it before it opens the file of an external link.
herr_t refuse_link(const char*, const char*, const char*, const char*, unsigned*, hid_t, void* found)
{
    *static_cast<bool*>(found) = true;
    return -1;
}

/// open(property list)
/// @param access  class of the property list
template <class Open>
hid_t open_without_links(hid_t access, const std::string& place, Open open)
{
    const Hdf5& h5 = hdf5();
    bool found = false;
    const Hdf5Handle plan(h5.H5Pcreate(access), h5.H5Pclose);
    if (!plan.valid() || h5.H5Pset_elink_cb(plan.id(), &refuse_link, &found) < 0) return -1;
    const hid_t opened = open(plan.id());
    if (found) refuse(place, in_other_file);
    return opened;
}

} // namespace

Hdf5Handle open_group(std::int64_t file, const std::string& path, const std::string& place)
{
    const Hdf5& h5 = hdf5();
    return {
        open_without_links(h5.group_access, place, [&](hid_t plan) { return h5.H5Gopen2(file, path.c_str(), plan); }),
        h5.H5Gclose};
}

Hdf5Handle open_dataset(std::int64_t file, const std::string& path, const std::string& place)
{
    const Hdf5& h5 = hdf5();
    Hdf5Handle opened(
        open_without_links(h5.dataset_access, place, [&](hid_t plan) { return h5.H5Dopen2(file, path.c_str(), plan); }),
        h5.H5Dclose);
    if (!opened.valid()) return opened;
    const Hdf5Handle plan(h5.H5Dget_create_plist(opened.id()), h5.H5Pclose);
    if (!plan.valid()) return {};
    if (h5.H5Pget_layout(plan.id()) == H5D_VIRTUAL || h5.H5Pget_external_count(plan.id()) > 0)
        refuse(place, in_other_file);
    return opened;
}

Hdf5File::Hdf5File(const std::filesystem::path& path) : name_(path.string())
{
    check_readable(path);
    file_ = {hdf5().H5Fopen(path.c_str(), read_only, H5P_DEFAULT), hdf5().H5Fclose};
    if (!file_.valid()) refuse(name_, "is not a complete HDF5 file, or is being written");
}

std::vector<std::string> Hdf5File::names_in(const std::string& group) const
{
    const Hdf5& h5 = hdf5();
    const Hdf5Handle opened = open_group(file_.id(), group, fmt::format("{}: {}", name_, group));
    H5G_info_t info{};
    if (!opened.valid() || h5.H5Gget_info(opened.id(), &info) < 0)
        refuse(name_, fmt::format("has no group '{}'", group));
    constexpr std::uint64_t most = 1000; // the first unknown name will be refused anyway
    std::vector<std::string> names;
    for (std::uint64_t i = 0; i < std::min<std::uint64_t>(info.nlinks, most); ++i) {
        std::array<char, 200> name{};
        if (h5.H5Lget_name_by_idx(opened.id(), ".", H5_INDEX_NAME, H5_ITER_INC, i, name.data(), name.size(),
                                  H5P_DEFAULT) < 0)
            refuse(name_, fmt::format("the group '{}' cannot be listed", group));
        names.emplace_back(name.data());
    }
    return names;
}

Hdf5Column Hdf5File::column(const std::string& path, Numbers numbers, const std::vector<std::uint64_t>& row) const
{
    const Hdf5& h5 = hdf5();
    Hdf5Column column;
    column.place_ = fmt::format("{}: {}", name_, path);
    std::string wanted =
        fmt::format("must be a dataset of {} numbers, rows", numbers == Numbers::real ? "real" : "whole");
    for (const std::uint64_t extent : row) wanted += extent ? fmt::format(" x {}", extent) : " x any";
    column.dataset_ = open_dataset(file_.id(), path, column.place_);
    if (!column.dataset_.valid()) refuse(column.place_, "cannot be opened; it " + wanted);
    column.space_ = {h5.H5Dget_space(column.dataset_.id()), h5.H5Sclose};
    const Hdf5Handle type(h5.H5Dget_type(column.dataset_.id()), h5.H5Tclose);
    if (!type.valid() || !column.space_.valid()) refuse(column.place_, "cannot be read");

    const H5T_class_t kind = h5.H5Tget_class(type.id());
    const std::size_t bytes = h5.H5Tget_size(type.id());
    if ((kind != H5T_INTEGER && (kind != H5T_FLOAT || numbers == Numbers::whole)) || bytes == 0 || bytes > 8)
        refuse(column.place_, "holds values of another type; it " + wanted);
    const int dimensions = std::max(0, h5.H5Sget_simple_extent_ndims(column.space_.id()));
    std::vector<hsize_t>& extent = column.extent_;
    extent.resize(static_cast<std::size_t>(dimensions));
    if (dimensions > 0) h5.H5Sget_simple_extent_dims(column.space_.id(), extent.data(), nullptr);
    bool right = extent.size() == row.size() + 1;
    for (std::size_t k = 0; right && k < row.size(); ++k) right = row[k] == 0 || row[k] == extent[k + 1];
    if (!right) refuse(column.place_, fmt::format("has the shape {}; it {}", fmt::join(extent, " x "), wanted));
    check_chunks(column.place_, column.dataset_.id(), dimensions, bytes);
    return column;
}

void Hdf5Column::read(const std::vector<hsize_t>& start, const std::vector<hsize_t>& extent, std::int64_t type,
                      void* out) const
{
    const Hdf5& h5 = hdf5();
    const Hdf5Handle memory(h5.H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), h5.H5Sclose);
    if (h5.H5Sselect_hyperslab(space_.id(), H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr) < 0 ||
        h5.H5Dread(dataset_.id(), type, memory.id(), space_.id(), H5P_DEFAULT, out) < 0)
        refuse(place_, fmt::format("rows {} to {} cannot be read; the file is damaged or cut off", start[0],
                                   start[0] + extent[0] - 1));
}

void Hdf5Column::read(std::uint64_t first, std::uint64_t count, std::int64_t type, void* out) const
{
    std::vector<hsize_t> start(extent_.size(), 0), extent = extent_;
    start[0] = first, extent[0] = count;
    read(start, extent, type, out);
}

void Hdf5Column::read_within(std::uint64_t row, std::uint64_t first, std::uint64_t count, double* out) const
{
    std::vector<hsize_t> start(extent_.size(), 0), extent = extent_;
    start[0] = row, extent[0] = 1, start[1] = first, extent[1] = count;
    read(start, extent, hdf5().native_double, out);
}

void Hdf5Column::read(std::uint64_t first, std::uint64_t count, double* out) const
{
    read(first, count, hdf5().native_double, out);
}

void Hdf5Column::read(std::uint64_t first, std::uint64_t count, std::int64_t* out) const
{
    read(first, count, hdf5().native_int64, out);
}

} // namespace oncollide
