#include <oncollide/base/files/program_output.hpp>

#include <oncollide/base/error.hpp>

// The programs that oncollide runs (converters of CAD files) are not part of its package for Windows.
namespace oncollide {

std::filesystem::path find_program(std::string_view)
{
    return {};
}

ProgramOutput output_of(const std::filesystem::path& program, std::vector<std::string>, const ProgramLimits&, int)
{
    throw Error(ErrorKind::no_input, program.string() + ": cannot be started: this build for Windows runs no programs");
}

} // namespace oncollide
