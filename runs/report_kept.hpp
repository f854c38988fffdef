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
/// More columns, if bodies move on the way (Pipeline::set_continuous).
inline constexpr std::string_view sweep_csv_header =
    "clear_until,contact_by,gap,separating,part_a,part_b,x,y,z,normal_x,normal_y,normal_z";
/// The first line of a CSV file.
std::string csv_first_line(bool continuous);
/// The cells of csv_header.
/// @param a, b  names that csv_field has returned
void add_csv_cells(CsvWriter& csv, std::uint64_t frame, const std::string& a, const std::string& b,
                   const PairResult& pair, std::string_view stage, double max_error);
/// The cells of sweep_csv_header; empty where there is no sweep, or the sweep does not give them.
void add_csv_cells(CsvWriter& csv, const PairSweep* sweep);
/// The values of sweep_csv_header as one row of JSON that begins with two names, in quotes, and the verdict.
void write_json_row(JsonWriter& json, const std::string& a, const std::string& b, const PairSweep& sweep);
/// True if a contact of two parts was found, not of a body inside the other.
bool has_parts(const SweepResult& sweep);
/// A triangle's number, or a cell as its lowest corner and its side, in units of the map's smallest cells.
std::string part_text(const BodyPart& part);

/// The sweeps of a frame by the numbers of their pairs, which must ascend from call to call.
class SweepOfPair {
public:
    explicit SweepOfPair(const FrameView& frame) : sweeps_(frame.sweeps) {}
    /// Null: there is none.
    const PairSweep* operator()(std::size_t pair)
    {
        while (!sweeps_.empty() && sweeps_.front().pair < pair) sweeps_ = sweeps_.subspan(1);
        return !sweeps_.empty() && sweeps_.front().pair == pair ? &sweeps_.front() : nullptr;
    }

private:
    std::span<const PairSweep> sweeps_;
};
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
