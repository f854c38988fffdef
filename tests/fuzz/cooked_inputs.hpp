// Cooked files that were damaged field by field, and what they may answer all the same.
#pragma once
#include <filesystem>
#include <random>
#include <string>

namespace oncollide::test {

/// One to three fields of the header, the nodes, the table, the parts or the chunks become something else, the file is
/// cut off at or beside the end of a section or a chunk, or bytes change anywhere. Whatever the bytes are.
std::string mutated_cooked(std::string bytes, std::mt19937_64& random);

/// Opens the file, and lets bodies collide with what is in it.
///
/// Damaged (its checksums are those of a seed): each result is that of the seed, or undecided with a fault that names
/// the file. Sealed (its checksums were made to fit): if check_cooked() finds nothing wrong, the results are those of
/// what is in it. Throws what opening and checking it throw; aborts where this does not hold.
void query_cooked(const std::filesystem::path& file, bool sealed);

} // namespace oncollide::test
