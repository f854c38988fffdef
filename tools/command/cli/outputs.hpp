#pragma once
#include <functional>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/arguments.hpp"

#include <oncollide/runs/report.hpp>

namespace oncollide::tools {

/// Files to write results to; empty: not written.
struct OutputOptions {
    std::string json, csv, trace, picture;
    std::string pairs; ///< used by 'run' only
    bool quiet = false;
    bool separate = false;
};

void add_output_options(Arguments command, OutputOptions& options);
/// Calls check_files() for these files; an empty `input` means no input.
void check_outputs(const OutputOptions& options, const std::string& input);
/// The parts of the report that these files need. A report that outgrows memory spills into the folder of the first
/// file.
ReportParts parts_of(const OutputOptions& options);
/// The files, for a message: "a.json, b.csv"; empty if there are none.
std::string names_of(const OutputOptions& options);
/// Calls each of `writes`, even after one throws, so that one output that cannot be written does not stop the others.
/// Throws the first Error, and prints further ones.
void write_all(std::initializer_list<std::function<void()>> writes);
/// Writes the stage table to standard output (to standard error if results go to standard output), then every file.
/// @param csv_line  first line of the CSV file, with its line break
void write_outputs(const Report& report, const OutputOptions& options, const std::string& csv_line = {});

/// An output file is also an input, which must not be overwritten; report it like an Error{usage}. It does not derive
/// from Error, because readers add the position in the file to an Error and turn it into bad data.
struct OverwritesInput : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Throws Error{usage} if the name of an output has an extension that is not one of its format.
/// @param valid  the valid extensions with dots, such as {".h5", ".hdf5"}
/// @param other  advice for the error; may be empty
void check_extension(const char* option, const std::string& file, std::initializer_list<std::string_view> valid,
                     std::string_view other = {});

/// Must be called before anything is read.
void watch_files();

/// Checks before any work that each file can be written, that all files differ, and that none of them is an input. Each
/// file comes with the option that names it; an empty name is skipped. Throws Error{cannot_write} or Error{usage}.
/// After watch_files(), every file read before counts as an input, and reading one of `files` later, under any name,
/// throws OverwritesInput.
void check_files(const std::vector<std::pair<const char*, std::string>>& files,
                 const std::vector<std::string>& inputs = {});

} // namespace oncollide::tools
