// Works without a fuzzer: writes the seeds of a format as a corpus, and loads inputs again.
//
//   fuzz_replay seeds FOLDER           writes FOLDER/FORMAT/seed-N for every format, and FOLDER/FORMAT.dict
//   fuzz_replay FORMAT [N] [PATH...]   loads the seeds (all must be accepted), N mutations of them, and the files given
#include "formats.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace {

using namespace oncollide::test;
namespace fs = std::filesystem;

/// The words of text seeds, quoted as in libFuzzer's dictionaries.
std::set<std::string> words_of(const std::string& seed)
{
    std::set<std::string> words;
    std::string word;
    for (const char c : seed + " ")
        if (std::isalnum(static_cast<unsigned char>(c)) || c == '_')
            word += c;
        else if (const std::string found = std::exchange(word, ""); found.size() > 1 && found.size() < 25)
            words.insert('"' + found + '"');
    return words;
}

void write_seeds(const fs::path& folder)
{
    for (const Format& format : formats()) {
        fs::create_directories(folder / format.name);
        std::set<std::string> words;
        int number = 0;
        for (const std::string& seed : format.seeds()) {
            std::ofstream(folder / format.name / fmt::format("seed-{}", number++), std::ios::binary) << seed;
            words.merge(words_of(seed));
        }
        std::ofstream dictionary(folder / fmt::format("{}.dict", format.name));
        for (const std::string& word : words) dictionary << word << "\n";
    }
}

/// Applies a few cuts, changed bytes, duplicated and swapped pieces.
std::string mutated(std::string bytes, std::mt19937_64& random)
{
    const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    for (std::size_t change = 0; change < 1 + pick(4) && !bytes.empty(); ++change) {
        const std::size_t at = pick(bytes.size()), length = 1 + pick(std::min<std::size_t>(bytes.size() - at, 30));
        switch (pick(6)) {
        case 0:
            bytes[at] = static_cast<char>(random());
            break;
        case 1:
            bytes[at] = "0123456789-e. {}[]\n\xff"[pick(20)];
            break;
        case 2:
            bytes.erase(at, length);
            break;
        case 3:
            bytes.insert(pick(bytes.size()), bytes.substr(at, length));
            break;
        case 4:
            bytes.replace(at, length, bytes.substr(pick(bytes.size()), length));
            break;
        case 5:
            if (pick(4) == 0) bytes.resize(at);
            break;
        }
    }
    return bytes;
}

int replay(const Format& format, int mutations, const std::vector<fs::path>& paths)
{
    const std::vector<std::string> seeds = format.seeds();
    int refused = 0, accepted = 0;
    for (const std::string& seed : seeds) refused += !load_bytes(format, seed);
    std::mt19937_64 random(7);
    for (int i = 0; i < mutations; ++i) {
        const std::string& seed = seeds[static_cast<std::size_t>(i) % seeds.size()];
        const bool known = format.mutated && random() % 8 > 0;
        accepted += load_bytes(format, known ? format.mutated(seed, random) : mutated(seed, random));
    }
    for (const fs::path& path : paths) {
        std::ifstream file(path, std::ios::binary);
        accepted += load_bytes(format, std::string(std::istreambuf_iterator<char>(file), {}));
    }
    fmt::print("{}: {} seeds, {} mutations and {} files; {} of these accepted\n", format.name, seeds.size(), mutations,
               paths.size(), accepted);
    if (refused) fmt::print(stderr, "{}: {} seeds were refused\n", format.name, refused);
    return refused ? 1 : 0;
}

} // namespace

int main(int argc, char** argv)
{
    std::vector<std::string> arguments(argv + 1, argv + argc);
    if (arguments.size() == 2 && arguments[0] == "seeds") return write_seeds(arguments[1]), 0;
    if (arguments.empty()) {
        fmt::print(stderr, "usage: fuzz_replay seeds FOLDER | fuzz_replay FORMAT [MUTATIONS] [PATH...]\n");
        return 64;
    }
    std::vector<fs::path> files;
    for (std::size_t i = 2; i < arguments.size(); ++i) {
        if (!fs::is_directory(arguments[i]))
            files.emplace_back(arguments[i]);
        else
            for (const auto& entry : fs::directory_iterator(arguments[i])) files.push_back(entry.path());
    }
    return replay(format_named(arguments[0]), arguments.size() > 1 ? std::atoi(arguments[1].c_str()) : 0, files);
}
