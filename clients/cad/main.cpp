// oncollide-cad: turns STEP, IGES and BREP files into GLB files, for `oncollide` and other programs.
#include <charconv>
#include <cmath>
#include <cstdio>
#include <new>
#include <string>
#include <string_view>

#include <Standard_Version.hxx>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include "model.hpp"

namespace oncollide::cad {
namespace {

constexpr const char* help =
    "Usage: oncollide-cad FILE -o OUT.glb [--deflection LENGTH]\n"
    "\n"
    "Turns a STEP (.step, .stp), IGES (.iges, .igs) or BREP (.brep, .brp) file into a GLB file, in metres, with the\n"
    "assembly's nodes, names, instances and colours. A node with a mesh has extras: \"deflection\", the largest "
    "distance\n"
    "between its triangles and the true surface, in metres.\n"
    "\n"
    "  -o OUT.glb             file to write\n"
    "  --deflection LENGTH    largest distance to reach, such as 0.1mm (mm, cm, m, in; default: a thousandth of the\n"
    "                         diagonal of each shape, from 0.01 mm to 1 mm)\n"
    "  --version              print the versions of this program and of Open CASCADE\n"
    "\n"
    "Exit codes: 0 success, 64 usage, 65 bad data, 66 no input, 70 out of memory, 73 cannot write.\n";

double length_of(std::string_view text)
{
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    std::string_view unit(end, std::size_t(text.data() + text.size() - end));
    while (unit.starts_with(' ')) unit.remove_prefix(1);
    const double metres = unit.empty() || unit == "mm" ? 1e-3
                          : unit == "cm"               ? 1e-2
                          : unit == "m"                ? 1
                          : unit == "in"               ? 0.0254
                                                       : 0;
    if (error != std::errc() || !(value * metres > 0) || !std::isfinite(value))
        throw Fault(usage, fmt::format("--deflection {}: expected a length above 0, such as 0.1mm", text));
    return value * metres;
}

/// A file that claims too much fails by itself, before the machine swaps.
void limit_memory()
{
    rlimit limit{};
    const auto all = rlim_t(::sysconf(_SC_PHYS_PAGES)) * rlim_t(::sysconf(_SC_PAGESIZE));
    if (::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur > all && limit.rlim_max > all) {
        limit.rlim_cur = all;
        ::setrlimit(RLIMIT_AS, &limit);
    }
}

void run(int count, char** words)
{
    std::string file, out;
    Options options;
    for (int i = 1; i < count; ++i) {
        const std::string_view word = words[i];
        const auto value = [&] {
            if (++i == count) throw Fault(usage, fmt::format("{} needs a value", word));
            return words[i];
        };
        if (word == "-h" || word == "--help") {
            std::fputs(help, stdout);
            return;
        }
        if (word == "--version") {
            std::fputs("oncollide-cad " ONCOLLIDE_CAD_VERSION ", Open CASCADE " OCC_VERSION_COMPLETE "\n", stdout);
            return;
        }
        if (word == "-o" || word == "--out")
            out = value();
        else if (word == "--deflection")
            options.deflection = length_of(value());
        else if (word.starts_with("-") || !file.empty())
            throw Fault(usage, fmt::format("unexpected argument '{}'; see --help", word));
        else
            file = word;
    }
    if (file.empty() || out.empty()) throw Fault(usage, "needs a FILE and -o OUT.glb; see --help");
    limit_memory();
    try {
        const Model model = read_model(file, options);
        for (const std::string& warning : model.warnings)
            fmt::print(stderr, "oncollide-cad: warning: {}: {}\n", file, warning);
        write_glb(model, out);
    } catch (const Fault& fault) {
        throw Fault(fault.code, fault.code == cannot_write ? fault.what() : file + ": " + fault.what());
    } catch (const std::bad_alloc&) {
        throw Fault(internal, file + ": out of memory");
    }
}

} // namespace
} // namespace oncollide::cad

int main(int count, char** words)
{
    try {
        oncollide::cad::run(count, words);
        return 0;
    } catch (const oncollide::cad::Fault& fault) {
        fmt::print(stderr, "oncollide-cad: error: {}\n", fault.what());
        return fault.code;
    } catch (const std::exception& error) {
        fmt::print(stderr, "oncollide-cad: error: {}\n", error.what());
        return oncollide::cad::internal;
    }
}
