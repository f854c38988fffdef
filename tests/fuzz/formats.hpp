// Every format of external files, for the fuzzers and the replay of their corpora.
#pragma once
#include <filesystem>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace oncollide::test {

struct Format {
    const char* name;                    ///< of its target and its corpus
    const char* file;                    ///< file name for the bytes; readers go by its extension
    std::vector<std::string> (*seeds)(); ///< small files that the readers accept
    /// Mutates with knowledge of the format; accepts any bytes. Null: the format has no such mutator.
    std::string (*mutated)(std::string, std::mt19937_64&) = nullptr;
};

std::span<const Format> formats();
/// Ends the program with a message if there is no such format.
const Format& format_named(std::string_view name);

/// Loads the bytes as a user's file of that format, from a temporary folder. The result must be valid, or one Error of
/// the kind bad_data or no_input, with one printable line that names the file. Otherwise aborts the program with a
/// message.
/// @return  true if they were accepted
bool load_bytes(const Format& format, std::string_view bytes);

/// Ends the program: a reader violated its contract.
[[noreturn]] void fault(const std::string& what);
void write_bytes(const std::filesystem::path& file, std::string_view bytes);

} // namespace oncollide::test
