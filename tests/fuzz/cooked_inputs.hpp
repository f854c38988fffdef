// Cooked files that are damaged field by field, and the results that are still allowed.
#pragma once
#include <filesystem>
#include <random>
#include <string>

namespace oncollide::test {

/// Changes one to three fields of the header, the nodes, the table, the parts or the chunks, cuts the file at or near
/// the end of a section or a chunk, or changes bytes anywhere. Accepts any bytes.
std::string mutated_cooked(std::string bytes, std::mt19937_64& random);

/// Opens the file, and lets bodies collide with its contents.
///
/// Damaged (its checksums are unchanged from a seed): each result must equal the seed's, or be undecided with a fault
/// that names the file. Sealed (its checksums were recomputed): if check_cooked() finds no fault, the results must
/// equal the results for its contents. Throws the errors of opening and checking; aborts if a requirement is violated.
void query_cooked(const std::filesystem::path& file, bool sealed);

} // namespace oncollide::test
