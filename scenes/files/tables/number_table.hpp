#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>

namespace oncollide {

/// Rows of finite numbers.
struct NumberTable {
    std::vector<std::string> names; ///< names of the columns, from a CSV file's first line; empty: the file has no
                                    ///< names
    std::size_t columns = 0;
    std::vector<double> numbers; ///< row by row

    std::size_t rows() const { return columns ? numbers.size() / columns : 0; }
};

/// Reads a table: .csv, with a first line of names or without; .npy, of two dimensions; .h5 and .hdf5, the dataset of
/// that path. Private to scenes and tools. Throws Error{no_input}; Error{bad_data} that names the line or the row of
/// the fault; Error{usage} for an unknown kind of file.
NumberTable load_number_table(const std::filesystem::path& path, const std::string& dataset);
NumberTable read_hdf5_table(const std::filesystem::path& path, const std::string& dataset);

} // namespace oncollide
