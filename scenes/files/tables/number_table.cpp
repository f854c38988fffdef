#include <oncollide/scenes/files/tables/number_table.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/text/csv_reader.hpp>
#include <oncollide/scenes/files/common/npy.hpp>
#include <oncollide/scenes/files/mesh/mesh_source.hpp>

namespace oncollide {

namespace {

constexpr std::uintmax_t most_table_bytes = std::uintmax_t{8} << 30;

NumberTable read_csv_table(const std::string& name, std::string_view text)
{
    NumberTable table;
    CsvReader csv(name, text, CsvReader::Style::list);
    std::vector<std::string> fields;
    for (; !csv.at_end(); csv.next_line()) {
        fields.clear();
        for (bool last = false; !last;) fields.emplace_back(csv.next(last));
        if (fields.size() == 1 && fields[0].empty()) continue; // an empty line, or a comment
        double value = 0;
        if (table.columns == 0) {
            table.columns = fields.size();
            if (std::ranges::none_of(fields, [&](const std::string& field) { return parse(field, value); })) {
                table.names = fields;
                continue;
            }
        }
        if (fields.size() != table.columns)
            csv.fail(fmt::format("{} numbers; the first line has {}", fields.size(), table.columns));
        for (const std::string& field : fields) {
            if (!parse(field, value) || !std::isfinite(value))
                csv.fail(oncollide::quoted(field) + " is not a finite number");
            table.numbers.push_back(value);
        }
    }
    return table;
}

NumberTable read_npy_table(const std::string& name, std::string_view bytes)
{
    const NpyHeader header = read_npy_header(name, bytes);
    if (header.shape.size() != 2 || header.columns_first)
        refuse(name, fmt::format("the shape is {}{}; it must have two dimensions, in the order of C", header.shape_text,
                                 header.columns_first ? ", in the order of Fortran" : ""));
    const double wanted = double(header.shape[0]) * double(header.shape[1]) * double(header.type.size);
    if (const std::size_t found = bytes.size() - header.bytes; wanted != double(found))
        refuse(name, fmt::format("{} numbers of {} bytes are announced, and {} bytes are there", header.shape_text,
                                 header.type.size, found));
    return {{}, static_cast<std::size_t>(header.shape[1]), decoded(header.type, bytes.substr(header.bytes))};
}

} // namespace

NumberTable load_number_table(const std::filesystem::path& path, const std::string& dataset)
{
    const std::string name = path.string(), kind = lower_extension(path);
    if (kind != ".csv" && kind != ".npy" && kind != ".h5" && kind != ".hdf5")
        throw Error(ErrorKind::usage,
                    fmt::format("{}: unknown kind of table '{}'; known are .csv, .npy, .h5, .hdf5", name, kind));
    NumberTable table;
    if (kind == ".h5" || kind == ".hdf5") {
        table = read_hdf5_table(path, dataset);
    } else {
        const FileBytes bytes = read_large_file(path, most_table_bytes);
        table = kind == ".csv" ? read_csv_table(name, bytes) : read_npy_table(name, bytes);
    }
    if (table.rows() == 0) refuse(name, "the table has no row");
    for (std::size_t i = 0; i < table.numbers.size(); ++i)
        if (!std::isfinite(table.numbers[i]))
            refuse(name, fmt::format("row {}, column {} is not a finite number", i / table.columns, i % table.columns));
    return table;
}

} // namespace oncollide
