// The main() of all programs. Each command has its own file.
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
    CommandLine line(program.name, program.summary, version_text());
    line.arguments().footer(program.footer);
    program.add_commands(line.arguments());
    return line.parse(argc, argv)();
}

} // namespace
} // namespace oncollide::tools

int main(int argc, char** argv)
{
    using namespace oncollide;
    using tools::log, tools::LogLevel;
    try {
        tools::set_program_name(tools::program.name);
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
    } catch (const std::filesystem::filesystem_error& error) { // the system refuses a path
        log(LogLevel::error, error.what());
        return int(ErrorKind::no_input);
    } catch (const std::bad_alloc&) {
        tools::write_to_stderr(tools::program_name()), tools::write_to_stderr(": out of memory\n");
    } catch (const std::length_error&) { // a vector larger than the address space
        tools::write_to_stderr(tools::program_name()), tools::write_to_stderr(": out of memory\n");
    } catch (const std::exception& error) {
        log(LogLevel::error, std::string("internal fault: ") + error.what());
    }
    return int(ErrorKind::internal);
}
