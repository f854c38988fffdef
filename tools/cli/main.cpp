// The oncollide command. Each subcommand has its own file.
#include "cli/build_info.hpp"
#include "cli/command.hpp"
#include "cli/log.hpp"
#include "cli/outputs.hpp"
#include "cli/progress.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"

#include <filesystem>

#include <oncollide/base/error.hpp>

namespace oncollide::tools {
namespace {

int parse_and_run(int argc, char** argv)
{
    CommandLine line("oncollide",
                     "Finds which bodies of a large environment collide, frame by frame, at a certified accuracy.",
                     version_text());
    line.arguments().footer(
        "Exit codes: 0 success, 64 usage, 65 bad data, 66 no input, 70 internal fault, 71 no GPU, 73 cannot write,\n"
        "130 interrupted. 'check' returns 0 separate, 1 colliding, 2 within or undecided; so does 'run --exit-code'.\n"
        "Environment: ONCOLLIDE_LOG=info or debug prints more to standard error, NO_COLOR=1 turns off colours.\n"
        "Start with 'oncollide demo', then 'oncollide COMMAND --help'.");
    add_commands(line.arguments());
    return line.parse(argc, argv)();
}

} // namespace
} // namespace oncollide::tools

int main(int argc, char** argv)
{
    using namespace oncollide;
    using tools::log, tools::LogLevel;
    try {
        tools::prepare_process();
        tools::set_log_level();
        tools::watch_files(), tools::show_reading(false);
        const int code = tools::parse_and_run(argc, argv);
        tools::check_stdout();
        return code;
    } catch (const Error& error) {
        log(LogLevel::error, error.what());
        return int(error.kind());
    } catch (const tools::OverwritesInput& error) {
        log(LogLevel::error, error.what());
        return int(ErrorKind::usage);
    } catch (const std::filesystem::filesystem_error& error) { // a path that the system refuses; no fault of ours
        log(LogLevel::error, error.what());
        return int(ErrorKind::no_input);
    } catch (const std::bad_alloc&) {
        tools::write_to_stderr("oncollide: out of memory\n");
    } catch (const std::length_error&) { // a vector larger than the address space
        tools::write_to_stderr("oncollide: out of memory\n");
    } catch (const std::exception& error) {
        log(LogLevel::error, std::string("internal fault: ") + error.what());
    }
    return int(ErrorKind::internal);
}
