#include <oncollide/scenes/files/tables/hdf5_file.hpp>
#include <oncollide/scenes/files/tables/number_table.hpp>

namespace oncollide {

NumberTable read_hdf5_table(const std::filesystem::path& path, const std::string& dataset)
{
    const Hdf5File file(path);
    const Hdf5Column column = file.column(dataset, Hdf5File::Numbers::real, {0});
    NumberTable table{{}, static_cast<std::size_t>(column.extent(1)), {}};
    constexpr std::uint64_t most = std::uint64_t{1} << 30; // numbers; a damaged file may announce any extent
    if (table.columns == 0 || column.rows() > most / table.columns)
        refuse(path.string(), dataset + ": has no column, or more than 2^30 numbers");
    table.numbers.resize(column.rows() * table.columns);
    if (!table.numbers.empty()) column.read(0, column.rows(), table.numbers.data());
    return table;
}

} // namespace oncollide
