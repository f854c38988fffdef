#include <oncollide/scenes/files/tables/hdf5_file.hpp>

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/hdf5/hdf5_links.hpp>

namespace oncollide {

Hdf5File::Hdf5File(const std::filesystem::path& path) : name_(path.string())
{
    check_readable(path);
    try {
        file_ = std::make_shared<const Hdf5Bytes>(path, Hdf5Bytes::Access::alone);
    } catch (const Hdf5Fault& fault) {
        refuse(name_, fault.what);
    }
}

std::vector<std::string> Hdf5File::names_in(const std::string& group) const
{
    try {
        Hdf5Walk walk(*file_);
        const auto object = find_hdf5_object(*file_, group);
        const auto links = object ? hdf5_links(walk, *object) : std::nullopt;
        if (!links) refuse(name_, fmt::format("has no group '{}'", group));
        std::vector<std::string> names;
        for (const Hdf5Link& link : *links) names.push_back(link.name);
        std::ranges::sort(names);
        return names;
    } catch (const Hdf5Fault& fault) {
        refuse(name_, fmt::format("{}: {}", group, fault.what));
    }
}

Hdf5Column Hdf5File::column(const std::string& path, Numbers numbers, const std::vector<std::uint64_t>& row) const
{
    const std::string place = fmt::format("{}: {}", name_, path);
    std::string wanted =
        fmt::format("must be a dataset of {} numbers, rows", numbers == Numbers::real ? "real" : "whole");
    for (const std::uint64_t extent : row) wanted += extent ? fmt::format(" x {}", extent) : " x any";
    try {
        const auto object = find_hdf5_object(*file_, path);
        if (!object) refuse(place, "cannot be opened; it " + wanted);
        Hdf5Dataset data(file_, *object);
        const Hdf5Type::Kind kind = data.type().kind;
        if (kind != Hdf5Type::Kind::whole && (kind != Hdf5Type::Kind::real || numbers == Numbers::whole))
            throw Hdf5Fault{hdf5_other_type};
        const std::vector<std::uint64_t>& extent = data.extent();
        bool right = extent.size() == row.size() + 1;
        for (std::size_t k = 0; right && k < row.size(); ++k) right = row[k] == 0 || row[k] == extent[k + 1];
        if (!right) refuse(place, fmt::format("has the shape {}; it {}", fmt::join(extent, " x "), wanted));
        return {place, std::move(data)};
    } catch (const Hdf5Fault& fault) {
        refuse(place, fault.what == hdf5_other_type ? fault.what + "; it " + wanted : fault.what);
    }
}

template <class Number>
void Hdf5Column::read(const std::vector<std::uint64_t>& start, const std::vector<std::uint64_t>& count,
                      Number* out) const
{
    try {
        read_hdf5_numbers(data_, start, count, out);
    } catch (const Hdf5Fault& fault) {
        refuse(place_, fmt::format("rows {} to {} cannot be read: {}", start[0], start[0] + count[0] - 1, fault.what));
    }
}

void Hdf5Column::read_within(std::uint64_t row, std::uint64_t first, std::uint64_t count, double* out) const
{
    std::vector<std::uint64_t> start(data_.extent().size(), 0), wanted = data_.extent();
    start[0] = row, wanted[0] = 1, start[1] = first, wanted[1] = count;
    read(start, wanted, out);
}

void Hdf5Column::read(std::uint64_t first, std::uint64_t count, double* out) const
{
    std::vector<std::uint64_t> start(data_.extent().size(), 0), wanted = data_.extent();
    start[0] = first, wanted[0] = count;
    read(start, wanted, out);
}

void Hdf5Column::read(std::uint64_t first, std::uint64_t count, std::int64_t* out) const
{
    std::vector<std::uint64_t> start(data_.extent().size(), 0), wanted = data_.extent();
    start[0] = first, wanted[0] = count;
    read(start, wanted, out);
}

} // namespace oncollide
