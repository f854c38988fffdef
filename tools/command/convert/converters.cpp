#include "convert/converters.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/paths.hpp>
#include <oncollide/base/files/program_output.hpp>
#include <oncollide/base/files/system_file.hpp>
#include <oncollide/base/text/file_warning.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

constexpr Converter cad{"oncollide-cad", "ONCOLLIDE_CAD", "STEP, IGES and BREP",
                        "Open CASCADE when oncollide is built (Debian: libocct-data-exchange-dev)"};
constexpr Converter ifc{"oncollide-ifc", "ONCOLLIDE_IFC", "IFC", "Node.js and the package in clients/ifc"};

constexpr std::array<std::pair<std::string_view, const Converter*>, 7> of_extension{
    {{"step", &cad}, {"stp", &cad}, {"iges", &cad}, {"igs", &cad}, {"brep", &cad}, {"brp", &cad}, {"ifc", &ifc}}};

constexpr ProgramLimits limits{.bytes = std::size_t(2) << 30, .time = std::chrono::hours(1)};
constexpr int cannot_start = 127; // exit code of a script whose interpreter, such as Node.js, is absent

bool is_program(const fs::path& path)
{
    return is_regular(path) && ::access(path.c_str(), X_OK) == 0;
}

struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
};

/// The texts after `mark` in the lines that have it.
std::vector<std::string> lines_with(const std::string& messages, std::string_view mark)
{
    std::vector<std::string> found;
    for (std::size_t begin = 0; begin < messages.size();) {
        const std::size_t end = std::min(messages.find('\n', begin), messages.size());
        const std::string_view line(messages.data() + begin, end - begin);
        if (const std::size_t at = line.find(mark); at != line.npos) found.emplace_back(line.substr(at + mark.size()));
        begin = end + 1;
    }
    return found;
}

/// The lines that it printed, to either stream.
std::string messages_of(const ProgramOutput& made)
{
    return made.output + '\n' + made.errors;
}

/// A message of the converter without the file's name, which the reader's messages begin with.
std::string without_name(const std::string& message, const std::string& name)
{
    return message.starts_with(name + ": ") ? message.substr(name.size() + 2) : message;
}

ErrorKind kind_of(int code)
{
    for (const ErrorKind kind : {ErrorKind::usage, ErrorKind::no_input, ErrorKind::internal, ErrorKind::cannot_write})
        if (code == int(kind)) return kind;
    return ErrorKind::bad_data;
}

[[noreturn]] void fail(const Converter& converter, const std::string& name, const ProgramOutput& made)
{
    const auto fail_as = [&](ErrorKind kind, const std::string& what) {
        throw Error(kind, printable(name + ": " + what));
    };
    using End = ProgramOutput::End;
    if (made.end == End::too_long)
        fail_as(ErrorKind::bad_data,
                fmt::format("{} was stopped after {} minutes", converter.program,
                            std::chrono::duration_cast<std::chrono::minutes>(limits.time).count()));
    if (made.end == End::killed && made.code == SIGXFSZ)
        fail_as(
            ErrorKind::bad_data,
            fmt::format("its triangles take more than {} GiB; a coarser --deflection has fewer", limits.bytes >> 30));
    if (made.end == End::killed && made.code == SIGKILL)
        fail_as(ErrorKind::bad_data, fmt::format("{} was killed; the system may lack memory", converter.program));
    if (made.end == End::killed)
        fail_as(ErrorKind::bad_data,
                fmt::format("{} crashed ({}) while it read the file", converter.program, ::strsignal(made.code)));
    if (made.code == cannot_start)
        fail_as(ErrorKind::no_input,
                fmt::format("{} cannot be started; it needs {}", converter.program, converter.needs));
    const std::vector<std::string> errors = lines_with(messages_of(made), "error: ");
    fail_as(kind_of(made.code), errors.empty() ? fmt::format("{} failed (exit code {})", converter.program, made.code)
                                               : without_name(errors.back(), name));
    std::abort();
}

std::string content_of(std::FILE* file)
{
    struct ::stat about {};
    std::string bytes;
    if (::fstat(::fileno(file), &about) == 0) bytes.resize(std::size_t(about.st_size));
    std::rewind(file);
    if (std::fread(bytes.data(), 1, bytes.size(), file) != bytes.size()) bytes.clear();
    return bytes;
}

std::string converted(const fs::path& file, const std::string& deflection)
{
    const Converter& converter = *converter_of(file);
    const std::string name = file.string(), program = find_program(converter);
    if (program.empty())
        throw Error(ErrorKind::no_input,
                    printable(fmt::format("{}: {} files are read by {}, which is not installed; it needs {}. Or export "
                                          "the parts as glTF (.glb) with their names",
                                          name, converter.formats, converter.program, converter.needs)));
    const std::unique_ptr<std::FILE, Close> output(open_nameless());
    if (!output)
        throw Error(ErrorKind::cannot_write, fmt::format("temporary file for {}: {}", name, std::strerror(errno)));
    std::vector<std::string> arguments{name.starts_with('-') ? "./" + name : name, "-o", "/dev/fd/3"};
    if (!deflection.empty()) arguments.insert(arguments.end(), {"--deflection", deflection});
    ProgramOutput made;
    try {
        made = output_of(program, arguments, limits, ::fileno(output.get()));
    } catch (const Error&) {
        made.code = cannot_start;
    }
    if (!made.is_good()) fail(converter, name, made);
    for (const std::string& line : lines_with(messages_of(made), "warning: "))
        warn_of_file(name, without_name(line, name));
    std::string bytes = content_of(output.get());
    if (bytes.empty()) refuse(name, fmt::format("{} wrote no mesh", converter.program));
    return bytes;
}

/// The version that a converter prints, or why it cannot convert: it may lack its interpreter or a package.
std::string state_of(const std::string& program)
{
    const ProgramOutput made = output_of(program, {"--version"}, {.time = std::chrono::seconds(10)});
    if (made.is_good()) return fmt::format("by {} ({})", program, made.output.substr(0, made.output.find('\n')));
    const std::vector<std::string> reasons = lines_with(messages_of(made), "error: ");
    return fmt::format("not usable by {}: {}", program, reasons.empty() ? "it does not start" : reasons.back());
}

} // namespace

const Converter* converter_of(const fs::path& file)
{
    const std::string extension = lower_extension(file);
    for (const auto& [known, converter] : of_extension)
        if (!extension.empty() && std::string_view(extension).substr(1) == known) return converter;
    return nullptr;
}

std::string find_program(const Converter& converter)
{
    if (const char* const named = std::getenv(converter.variable); named && *named) {
        if (is_program(named)) return named;
        throw Error(ErrorKind::no_input, fmt::format("{}={}: not a program", converter.variable, named));
    }
    std::error_code error;
    const fs::path here = fs::read_symlink("/proc/self/exe", error).parent_path();
    std::vector<fs::path> folders;
    if (!here.empty()) folders = {here, here.parent_path() / "libexec/oncollide"};
    for (const fs::path& folder : folders)
        if (const fs::path path = folder / converter.program; is_program(path)) return path.string();
    return oncollide::find_program(converter.program).string();
}

void read_converted_files(const std::string& deflection)
{
    std::vector<std::string> extensions;
    for (const auto& [extension, converter] : of_extension) extensions.emplace_back(extension);
    convert_files(std::move(extensions), [deflection](const fs::path& file) { return converted(file, deflection); });
}

std::vector<std::pair<std::string, std::string>> describe_converters()
{
    std::vector<std::pair<std::string, std::string>> lines;
    for (const Converter* const converter : {&cad, &ifc}) {
        std::string what;
        try {
            const std::string program = find_program(*converter);
            what = program.empty()
                       ? fmt::format("not installed: no {} files; it needs {}", converter->formats, converter->needs)
                       : printable(fmt::format("{} files, {}", converter->formats, state_of(program)));
        } catch (const Error& error) {
            what = error.what();
        }
        lines.emplace_back(converter->program, what);
    }
    return lines;
}

} // namespace oncollide::tools
