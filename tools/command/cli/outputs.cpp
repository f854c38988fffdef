#include "cli/outputs.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/base/files/output_file.hpp>

#include "cli/log.hpp"
#include "cli/standard_output.hpp"
#include "cli/system.hpp"

namespace oncollide::tools {
namespace {

namespace fs = std::filesystem;

bool same_place(const std::string& a, const std::string& b)
{
    if (a == "-" || b == "-") return a == b;
    if (const std::string identity = file_identity(a); !identity.empty() && identity == file_identity(b)) return true;
    std::error_code error;
    return fs::weakly_canonical(absolute_path(a), error) == fs::weakly_canonical(absolute_path(b), error);
}

/// Files that the program has read and will write, by identity. The program runs one command.
std::set<std::string> files_read;
std::map<std::string, std::string> files_to_write; ///< value: the option and the file's name

void note_read(const fs::path& path)
{
    static std::mutex guard; // files are read by several threads
    const std::lock_guard lock(guard);
    if (logged(LogLevel::debug)) log(LogLevel::debug, fmt::format("reading {}", path.string()));
    const std::string identity = file_identity(path.string());
    files_read.insert(identity);
    if (const auto found = files_to_write.find(identity); found != files_to_write.end())
        throw OverwritesInput(fmt::format("{}: would overwrite the input {}", found->second, path.string()));
}

void note_output(const char* option, const std::string& file)
{
    const std::string identity = file_identity(file);
    if (identity.empty() || file == "-") return;
    if (files_read.contains(identity)) usage(fmt::format("{} {}: would overwrite an input", option, file));
    files_to_write.emplace(identity, fmt::format("{} {}", option, file));
}

} // namespace

void watch_files()
{
    on_file_read(&note_read);
}

void add_output_options(Arguments command, OutputOptions& o)
{
    command.group("Results");
    const auto add = [&](const char* option, std::string& file, const char* what) {
        command.add_option(fmt::format("{} FILE", option), file, what);
    };
    add("--json", o.json, "write results as JSON; '-' is standard output");
    add("--csv", o.csv, "write one CSV row per frame and pair");
    add("--trace", o.trace, "write a trace for Perfetto or chrome://tracing");
    add("--picture", o.picture, "write a picture of stages and times (SVG)");
    command.add_flag("--separate", o.separate, "also record separate pairs");
    command.add_flag("--quiet", o.quiet, "print only errors");
    command.group("Options");
}

void check_outputs(const OutputOptions& o, const std::string& input)
{
    check_files(
        {{"--json", o.json}, {"--csv", o.csv}, {"--trace", o.trace}, {"--picture", o.picture}, {"--pairs", o.pairs}},
        {input});
    check_extension("--pairs", o.pairs, {".h5", ".hdf5"}, "; CSV is written by --csv");
    check_extension("--picture", o.picture, {".svg"}, "; 'oncollide render' draws the scene as PNG");
}

void check_extension(const char* option, const std::string& file, std::initializer_list<std::string_view> valid,
                     std::string_view other)
{
    const std::string found = lower_extension(file);
    if (!found.empty() && std::ranges::find(valid, found) == valid.end())
        usage(fmt::format("{} {}: is not written as '{}'; valid: {}{}", option, file, found, fmt::join(valid, ", "),
                          other));
}

void check_files(const std::vector<std::pair<const char*, std::string>>& files, const std::vector<std::string>& inputs)
{
    for (std::size_t k = 0; k < files.size(); ++k) {
        const auto& [option, file] = files[k];
        if (file.empty()) continue;
        for (const std::string& input : inputs)
            if (!input.empty() && file != "-" && same_place(file, input))
                usage(fmt::format("{} {}: would overwrite the input", option, file));
        for (std::size_t j = 0; j < k; ++j)
            if (std::error_code error;
                !files[j].second.empty() && same_place(file, files[j].second) && !fs::is_character_file(file, error))
                usage(fmt::format("{} and {} both go to '{}'", files[j].first, option, file));
        check_writable(file);
        note_output(option, file);
    }
}

void write_all(std::initializer_list<std::function<void()>> writes)
{
    std::optional<Error> first;
    for (const auto& write : writes) try {
            write();
        } catch (const Error& error) {
            if (first) log(LogLevel::error, error.what());
            if (!first) first = error;
        }
    if (first) throw *first;
}

ReportParts parts_of(const OutputOptions& o)
{
    ReportParts parts{
        .json = !o.json.empty(), .csv = !o.csv.empty(), .trace = !o.trace.empty(), .separate = o.separate};
    for (const std::string& file : {o.json, o.csv, o.trace})
        if (parts.folder.empty() && !file.empty() && file != "-") parts.folder = absolute_path(file).parent_path();
    return parts;
}

std::string names_of(const OutputOptions& o)
{
    std::string names;
    for (const std::string& file : {o.json, o.csv, o.trace, o.picture, o.pairs})
        if (!file.empty()) names += (names.empty() ? "" : ", ") + (file == "-" ? "standard output" : file);
    return names;
}

void write_outputs(const Report& report, const OutputOptions& o, const std::string& csv_line)
{
    const bool stdout_taken = o.json == "-" || o.csv == "-" || o.trace == "-" || o.picture == "-";
    // Writes the table first: if the disk is full after a long run, the numbers are at least on the screen.
    if (!o.quiet) {
        std::ostringstream table;
        report.print_table(table);
        write_to_stdout(table.str(), stdout_taken);
    }
    flush_stdout();
    write_all({[&] {
                   if (!o.json.empty()) report.write_json(o.json);
               },
               [&] {
                   if (!o.csv.empty()) report.write_csv(o.csv, csv_line);
               },
               [&] {
                   if (!o.trace.empty()) report.write_trace(o.trace);
               },
               [&] {
                   if (!o.picture.empty()) report.write_picture(o.picture);
               }});
    if (const std::string names = names_of(o); !names.empty()) log(LogLevel::info, "written: " + names);
}

} // namespace oncollide::tools
