#include <oncollide/scenes/files/converted_file.hpp>

#include <algorithm>
#include <utility>

#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide {

namespace {

std::vector<std::string> other_extensions;
FileConverter convert_other;

} // namespace

void convert_files(std::vector<std::string> extensions, FileConverter convert)
{
    if (!convert) extensions.clear();
    other_extensions = std::move(extensions), convert_other = std::move(convert);
}

const std::vector<std::string>& converted_extensions()
{
    return other_extensions;
}

bool is_converted_file(const std::filesystem::path& path)
{
    const std::string extension = lower_extension(path);
    return !extension.empty() && std::ranges::count(other_extensions, extension.substr(1)) > 0;
}

std::string converted_file(const std::filesystem::path& path)
{
    check_readable(path);
    return convert_other(path);
}

} // namespace oncollide
