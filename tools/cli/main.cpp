// The oncollide command: subcommands are added here, each lives in a file of its own.
#include "cli/command.hpp"
#include "cli/outputs.hpp"
#include "cli/system.hpp"

#include <iostream>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/printable.hpp>
#include <oncollide/pipeline/report.hpp>

namespace oncollide::tools {
namespace {

int parse_and_run(int argc, char** argv)
{
    CommandLine line("oncollide",
                     "Finds which bodies of a large environment collide, frame by frame, at a certified accuracy.",
                     fmt::format("oncollide {}", version));
    line.arguments().footer(
        "Exit codes: 0 success, 64 usage, 65 bad data, 66 no input, 70 internal fault, 71 no GPU, 73 cannot write,\n"
        "130 interrupted. 'check' returns 0 separate, 1 colliding, 2 within or undecided.\n"
        "Start with:  oncollide demo\n"
        "Then:        oncollide COMMAND --help");
    add_commands(line.arguments());
    return line.parse(argc, argv)();
}

} // namespace
} // namespace oncollide::tools

int main(int argc, char** argv)
{
    using namespace oncollide;
    try {
        tools::prepare_process();
        tools::watch_files();
        int code = tools::parse_and_run(argc, argv);
        if (!std::cout.flush()) throw Error(ErrorKind::cannot_write, "standard output: cannot write");
        return code;
    } catch (const Error& error) {
        std::cerr << "oncollide: " << error.what() << "\n";
        return int(error.kind());
    } catch (const tools::OverwritesInput& error) {
        std::cerr << "oncollide: " << printable(error.what()) << "\n";
        return int(ErrorKind::usage);
    } catch (const std::bad_alloc&) {
        std::cerr << "oncollide: out of memory\n";
    } catch (const std::length_error&) { // a vector of more than the address space
        std::cerr << "oncollide: out of memory\n";
    } catch (const std::exception& error) {
        std::cerr << "oncollide: internal fault: " << printable(error.what()) << "\n";
    }
    return int(ErrorKind::internal);
}
