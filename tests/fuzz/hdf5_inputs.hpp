// HDF5 files, damaged with knowledge of their structures.
#pragma once
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>

namespace oncollide::test {

/// Tables, recordings and results, in all layouts that are read.
std::vector<std::string> hdf5_seeds();

/// Changes numbers, links and sizes within structures and corrects the checksums, or cuts the file, or copies parts of
/// it elsewhere. Accepts any bytes.
std::string mutated_hdf5(std::string bytes, std::mt19937_64& random);

/// Reads the file as a table of bodies, a recording and results. Throws the last error if none of them can be read.
/// @param check  is called with every error
void read_hdf5(const std::filesystem::path& file, void (*check)(const Error&, const std::filesystem::path&));

} // namespace oncollide::test
