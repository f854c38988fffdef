#include <oncollide/scenes/files/tables/body_table.hpp>

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/reading_progress.hpp>
#include <oncollide/scenes/files/tables/hdf5_file.hpp>

namespace oncollide {

namespace {

enum Real { position, rotation, velocity, reals };
enum Whole { geometry, layer, mask, group, fixed, wholes };
constexpr std::array<std::string_view, reals> real_names = {"position", "rotation", "velocity"};
constexpr std::array<std::uint64_t, reals> widths = {3, 4, 3};
constexpr std::array<std::string_view, wholes> whole_names = {"geometry", "layer", "mask", "group", "static"};

/// Reads the columns of a table block by block.
class Columns {
public:
    Columns(const BodyRows& rows, const std::filesystem::path& path, const std::string& where)
        : rows_(rows), where_(where), file_(path)
    {
        std::vector<std::string> names = file_.names_in(where);
        for (const std::string& name : names)
            if (std::ranges::find(real_names, name) == real_names.end() &&
                std::ranges::find(whole_names, name) == whole_names.end())
                refuse(rows.file(), fmt::format("{}/{}: unknown column; valid: {}, {}", where, name,
                                                fmt::join(real_names, ", "), fmt::join(whole_names, ", ")));
        const auto has = [&](std::string_view name) { return std::ranges::find(names, name) != names.end(); };
        for (std::size_t c = 0; c < reals; ++c)
            if (has(real_names[c])) real_[c] = open(real_names[c], Hdf5File::Numbers::real, {widths[c]});
        for (std::size_t c = 0; c < wholes; ++c)
            if (has(whole_names[c])) whole_[c] = open(whole_names[c], Hdf5File::Numbers::whole, {});
        if (!real_[position]) refuse(rows.file(), fmt::format("{}: the column 'position' is missing", where));
        if (rows.geometry() && whole_[geometry])
            refuse(rows.file(),
                   fmt::format("{}/geometry: exists, and the scene file gives a geometry for all rows", where));
        if (!rows.geometry() && !whole_[geometry])
            refuse(rows.file(), fmt::format("{}: the column 'geometry' is missing", where));
        size_ = real_[position]->rows();
        for (std::size_t c = 0; c < reals; ++c) check_size(real_[c], real_names[c]);
        for (std::size_t c = 0; c < wholes; ++c) check_size(whole_[c], whole_names[c]);
    }

    std::uint64_t size() const { return size_; }

    /// Adds the bodies of `count` rows from `first` on.
    void add(std::uint64_t first, std::uint64_t count, BodyRows& rows)
    {
        for (std::size_t c = 0; c < reals; ++c)
            if (real_[c])
                real_values_[c].resize(count * widths[c]), real_[c]->read(first, count, real_values_[c].data());
        for (std::size_t c = 0; c < wholes; ++c)
            if (whole_[c]) whole_values_[c].resize(count), whole_[c]->read(first, count, whole_values_[c].data());
        for (std::uint64_t i = 0; i < count; ++i) {
            const auto place = [&] { return fmt::format("{}: {}: row {}", rows.file(), where_, first + i); };
            rows.add(row(i, place), place);
        }
    }

private:
    Hdf5Column open(std::string_view name, Hdf5File::Numbers numbers, const std::vector<std::uint64_t>& row) const
    {
        return file_.column(fmt::format("{}/{}", where_, name), numbers, row);
    }
    void check_size(const std::optional<Hdf5Column>& column, std::string_view name) const
    {
        if (column && column->rows() != size_)
            refuse(rows_.file(),
                   fmt::format("{}/{}: has {} rows; position has {}", where_, name, column->rows(), size_));
    }
    BodyRow row(std::uint64_t i, FunctionRef<std::string()> place) const
    {
        BodyRow row;
        row.position = Eigen::Map<const Eigen::Vector3d>(&real_values_[position][3 * i]);
        if (real_[rotation]) row.rotation = Eigen::Map<const Eigen::Vector4d>(&real_values_[rotation][4 * i]);
        if (real_[velocity]) row.velocity = Eigen::Map<const Eigen::Vector3d>(&real_values_[velocity][3 * i]);
        const auto whole = [&](Whole c, std::uint32_t otherwise, std::uint32_t most) {
            if (!whole_[c]) return otherwise;
            const std::int64_t value = whole_values_[c][i];
            if (value < 0 || value > most)
                refuse(place(), fmt::format("{} is {}; it must be from 0 to {}", whole_names[c], value, most));
            return static_cast<std::uint32_t>(value);
        };
        const std::size_t geometries = rows_.scene().geometries().size();
        row.geometry = rows_.geometry() ? *rows_.geometry()
                                        : GeometryId{whole(geometry, 0, static_cast<std::uint32_t>(geometries) - 1)};
        row.layer = whole(layer, row.layer, 0xffffffffu), row.mask = whole(mask, row.mask, 0xffffffffu);
        row.group = whole(group, row.group, 0xffffffffu), row.is_static = whole(fixed, 0, 1) == 1;
        return row;
    }

    const BodyRows& rows_;
    std::string where_;
    Hdf5File file_;
    std::array<std::optional<Hdf5Column>, reals> real_;
    std::array<std::optional<Hdf5Column>, wholes> whole_;
    std::array<std::vector<double>, reals> real_values_;
    std::array<std::vector<std::int64_t>, wholes> whole_values_;
    std::uint64_t size_ = 0;
};

} // namespace

void read_hdf5_bodies(BodyRows& rows, const std::filesystem::path& path, const std::string& group)
{
    Columns columns(rows, path, group);
    // Unwritten rows take no space in the file, but would fill the memory.
    constexpr std::uint64_t always = 1'000'000, block = 65'536;
    if (columns.size() > always && columns.size() > bytes_of_file(path))
        refuse(rows.file(), fmt::format("{} rows are announced; the file is too short for them", columns.size()));
    if (rows.scene().geometries().size() == 0) refuse(rows.file(), "the scene has no geometries");
    rows.expect(columns.size());
    const std::uint64_t bytes = bytes_of_file(path);
    ReadingProgress progress(rows.file(), bytes);
    for (std::uint64_t row = 0; row < columns.size();) {
        if (rows.skip()) {
            ++row;
            continue;
        }
        const std::uint64_t count = rows.wanted(std::min(block, columns.size() - row));
        columns.add(row, count, rows);
        row += count;
        progress.at(static_cast<std::uint64_t>(double(bytes) * double(row) / double(columns.size())));
    }
}

} // namespace oncollide
