#include <oncollide/base/files/paths.hpp>

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/utf8.hpp>

namespace oncollide {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view local = "file://";

} // namespace

fs::path path_of(std::string_view name)
{
#ifdef _WIN32
    for (std::string_view rest = name; !rest.empty();) {
        const auto [code, bytes] = first_character(rest);
        if (code == Utf8Character::none)
            throw Error(ErrorKind::no_input, fmt::format("{}: a name of a file must be UTF-8", as_utf8(name)));
        rest.remove_prefix(bytes);
    }
    return std::u8string_view(reinterpret_cast<const char8_t*>(name.data()), name.size());
#else
    return name;
#endif
}

std::string portable_name(const fs::path& path)
{
    return path.generic_string();
}

fs::path absolute_path(const fs::path& path)
{
    if (path.is_absolute()) return path;
    std::error_code error;
    const fs::path current = fs::current_path(error);
    if (error)
        throw Error(ErrorKind::no_input,
                    fmt::format("{}: the current folder cannot be found: {}", path.string(), error.message()));
    return current / path;
}

fs::path path_from(const fs::path& folder, const fs::path& file)
{
    std::error_code error;
    const fs::path path = fs::proximate(file, folder, error);
    return error ? absolute_path(file).lexically_proximate(absolute_path(folder)) : path;
}

bool is_folder(const fs::path& path)
{
    std::error_code error;
    return fs::is_directory(path, error);
}

bool is_regular(const fs::path& path)
{
    std::error_code error;
    return fs::is_regular_file(path, error);
}

std::uintmax_t bytes_of_file(const fs::path& path)
{
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(path, error);
    if (error) throw Error(ErrorKind::no_input, fmt::format("{}: cannot be read: {}", path.string(), error.message()));
    return bytes;
}

fs::path temporary_files()
{
    std::error_code error;
    const fs::path folder = fs::temp_directory_path(error);
    if (error) throw Error(ErrorKind::cannot_write, fmt::format("the folder of TMPDIR: {}", error.message()));
    return folder;
}

bool is_address(std::string_view name)
{
    const std::string_view scheme = name.substr(0, std::min(name.find("://"), name.size()));
    const auto may_stand = [](unsigned char c) { return std::isalnum(c) || c == '+' || c == '-' || c == '.'; };
    return scheme.size() < name.size() && !name.starts_with(local) && !scheme.empty() &&
           std::isalpha(static_cast<unsigned char>(scheme.front())) && std::ranges::all_of(scheme, may_stand);
}

fs::path file_in(const fs::path& folder, std::string_view name)
{
    if (is_address(name))
        throw Error(ErrorKind::no_input,
                    fmt::format("{}: is an address; files are read from this machine only: save a copy of it", name));
    if (name.starts_with(local)) name.remove_prefix(local.size());
    const fs::path path = folder / path_of(name);
    return path == "-" ? fs::path("./-") : path;
}

} // namespace oncollide
