#pragma once
#include <optional>
#include <string>
#include <vector>

#include <oncollide/base/files/spool.hpp>
#include <oncollide/base/text/csv_writer.hpp>
#include <oncollide/base/text/json_writer.hpp>
#include <oncollide/runs/pair_list.hpp>
#include <oncollide/runs/report.hpp>
#include <oncollide/runs/stage_times.hpp>

namespace oncollide {

inline constexpr std::string_view csv_header = "frame,a,b,verdict,gap_bound,stage,kind,max_error\n";
/// @param a, b  names as returned by csv_field
void write_csv_row(CsvWriter& csv, std::uint64_t frame, const std::string& a, const std::string& b,
                   const PairResult& pair, std::string_view stage, double max_error);
/// Lines of the stage table.
std::string stage_table(std::span<const StageStats> totals);
std::string verdict_line(const std::array<std::uint64_t, 4>& counts);
std::string bytes_text(std::size_t bytes);

struct Report::Kept {
    /// Frames as text, and the names of the bodies: quoted once instead of once per row.
    template <class Writer>
    struct Part {
        Spool text;
        Writer writer{text};
        std::vector<std::string> names{};
        explicit Part(const std::filesystem::path& folder) : text(folder) {}
    };
    std::optional<Part<JsonWriter>> json;
    std::optional<Part<CsvWriter>> csv;
    std::optional<Spool> trace;
    double trace_us = 0; ///< start of the next frame in the trace
    StageTimes stage_times;
    PairList colliding, unsure; ///< unsure: within or undecided
};

} // namespace oncollide
