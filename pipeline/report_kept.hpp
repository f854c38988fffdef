#pragma once
#include <optional>
#include <string>
#include <vector>

#include <oncollide/base/spool.hpp>
#include <oncollide/pipeline/pair_list.hpp>
#include <oncollide/pipeline/report.hpp>
#include <oncollide/pipeline/stage_times.hpp>

namespace oncollide {

inline constexpr std::string_view csv_header = "frame,a,b,verdict,gap_bound,stage,kind,max_error\n";
/// RFC 4180: adds quotes only if the field needs them.
std::string csv_field(const std::string& text);
/// @param a, b  names as returned by csv_field
std::string csv_row(std::uint64_t frame, const std::string& a, const std::string& b, const PairResult& pair,
                    std::string_view stage, double max_error);
/// Lines of the stage table.
std::string stage_table(std::span<const StageStats> totals);
std::string verdict_line(const std::array<std::uint64_t, 4>& counts);
/// Digits in groups of three: 1,234,567.
std::string grouped(std::uint64_t value);
std::string bytes_text(std::size_t bytes);

struct Report::Kept {
    /// Frames as text, and the bodies' names, quoted once instead of once per row.
    struct Part {
        Spool text;
        std::vector<std::string> names;
    };
    std::optional<Part> json, csv;
    std::optional<Spool> trace;
    double trace_us = 0; ///< start of the next frame in the trace
    StageTimes stage_times;
    PairList colliding, unsure; ///< unsure: within or undecided
};

} // namespace oncollide
