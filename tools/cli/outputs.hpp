#pragma once
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cli/arguments.hpp"

#include <oncollide/pipeline/report.hpp>

namespace oncollide::tools {

/// Files that results go to; empty: not written.
struct OutputOptions {
    std::string json, csv, trace, picture;
    std::string pairs; ///< of 'run' alone
    bool quiet = false;
    bool separate = false;
};

void add_output_options(Arguments command, OutputOptions& options);
/// check_files() of these; an empty input is none.
void check_outputs(const OutputOptions& options, const std::string& input);
/// What the report must keep for them: in the folder of the first file, if it outgrows memory.
ReportParts parts_of(const OutputOptions& options);
/// The files, for a message: "a.json, b.csv"; empty if there are none.
std::string names_of(const OutputOptions& options);
/// The stage table to standard output (standard error when results go there), then every file requested.
/// @param csv_line  a first line of the CSV file, with its line break
void write_outputs(const Report& report, const OutputOptions& options, const std::string& csv_line = {});

/// An output is also an input, which must not be lost; the message is that of an Error{usage}. No Error itself: readers
/// say of those where in their file they happened, and make wrong data of them.
struct OverwritesInput : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// To be called before anything is read.
void watch_files();

/// Finds out before any work that a file could not be written, or that two of them, or one and an input, are the same
/// place. Files come with the option that names them; empty ones are not written. Throws Error{cannot_write} or
/// Error{usage}. Where files are watched, what was read before counts
/// as an input, and whoever reads one of the files later, wherever it is named, throws OverwritesInput.
void check_files(const std::vector<std::pair<const char*, std::string>>& files,
                 const std::vector<std::string>& inputs = {});

} // namespace oncollide::tools
