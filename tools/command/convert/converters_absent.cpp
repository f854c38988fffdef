// Replaces converters.cpp on Windows, whose package has no converters.
#include "convert/converters.hpp"

namespace oncollide::tools {

const Converter* converter_of(const std::filesystem::path&)
{
    return nullptr;
}

std::string find_program(const Converter&)
{
    return {};
}

void read_converted_files(const std::string&) {}

std::vector<std::pair<std::string, std::string>> describe_converters()
{
    const std::string absent = "not on Windows: export the parts as glTF (.glb) with their names";
    return {{"oncollide-cad", absent}, {"oncollide-ifc", absent}};
}

} // namespace oncollide::tools
