// Every format that a file from outside may have, as the fuzzers and the replay of their corpora see it.
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
    const char* file;                    ///< the name under which bytes are loaded; the readers go by its ending
    std::vector<std::string> (*seeds)(); ///< files that the readers accept, small
    /// Changes what means something in this format, in bytes that may be anything; null: nothing is known of it.
    std::string (*mutated)(std::string, std::mt19937_64&) = nullptr;
};

std::span<const Format> formats();
/// Ends the program with a message when there is none of that name.
const Format& format_named(std::string_view name);

/// Loads the bytes as a user's file of that format is loaded, from a temporary folder. Whatever they are, the answer
/// must be something valid or one Error: of the kind bad_data or no_input, of one printable line, which names the file.
/// Aborts the program with a message otherwise.
/// @return  were they accepted?
bool load_bytes(const Format& format, std::string_view bytes);

/// Ends the program: what a reader promises does not hold.
[[noreturn]] void fault(const std::string& what);
void write_bytes(const std::filesystem::path& file, std::string_view bytes);

} // namespace oncollide::test
