#include <oncollide/runs/ranks/ranked_report.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/runs/report_kept.hpp>

namespace oncollide {

namespace {

constexpr std::size_t most_lines = 32;
constexpr std::string_view phase_names[] = {"move", "exchange", "step", "results"};

struct ReportColumn {
    const char* name;
    double (*value)(const RankStatistics&);
    bool bytes = false;
};
double mean_per_frame(double sum, const RankStatistics& r)
{
    return r.frames ? sum / double(r.frames) : 0;
}
const ReportColumn columns[] = {
    {"bodies", [](const RankStatistics& r) { return mean_per_frame(double(r.bodies), r); }},
    {"ghosts", [](const RankStatistics& r) { return mean_per_frame(double(r.ghosts), r); }},
    {"pairs", [](const RankStatistics& r) { return mean_per_frame(double(r.pairs), r); }},
    {"work", [](const RankStatistics& r) { return mean_per_frame(double(r.work), r); }},
    {"moved in", [](const RankStatistics& r) { return mean_per_frame(double(r.came), r); }},
    {"sent", [](const RankStatistics& r) { return mean_per_frame(double(r.sent_bytes), r); }, true},
    {"step ms", [](const RankStatistics& r) { return mean_per_frame(r.step_ms, r); }},
    {"wait ms", [](const RankStatistics& r) { return mean_per_frame(r.wait_ms, r); }},
    {"memory", [](const RankStatistics& r) { return double(r.peak_memory); }, true},
};

template <class Of>
std::string line(const std::string& name, Of of)
{
    std::string text = fmt::format("{:<9}", name);
    for (const ReportColumn& column : columns) {
        const double value = of(column);
        text += fmt::format(" {:>11}", column.bytes   ? bytes_text(std::size_t(value))
                                       : value < 1000 ? fmt::format("{:.1f}", value)
                                                      : grouped(std::uint64_t(value + 0.5)));
    }
    return text + "\n";
}

} // namespace

std::string rank_table(const std::vector<RankStatistics>& ranks)
{
    std::string text = fmt::format("{:<9}", "process");
    for (const ReportColumn& column : columns) text += fmt::format(" {:>11}", column.name);
    text += "   mean per frame\n";
    if (ranks.size() <= most_lines) {
        for (std::size_t rank = 0; rank < ranks.size(); ++rank)
            text +=
                line(fmt::format("{}", rank), [&](const ReportColumn& column) { return column.value(ranks[rank]); });
    } else {
        const auto over_ranks = [&](auto take) {
            return [&, take](const ReportColumn& column) {
                std::vector<double> values;
                for (const RankStatistics& r : ranks) values.push_back(column.value(r));
                return take(values);
            };
        };
        text += line("least", over_ranks([](const auto& v) { return *std::ranges::min_element(v); }));
        text += line("mean", over_ranks([](const auto& v) {
                         double sum = 0;
                         for (const double value : v) sum += value;
                         return sum / double(v.size());
                     }));
        text += line("most", over_ranks([](const auto& v) { return *std::ranges::max_element(v); }));
    }
    std::uint64_t most = 0, all = 0;
    for (const RankStatistics& r : ranks) most = std::max(most, r.work), all += r.work;
    if (all)
        text += fmt::format("imbalance  {:.2f}: largest work of a process divided by the mean\n",
                            double(most) * double(ranks.size()) / double(all));
    return text;
}

void write_rank_csv(const std::filesystem::path& path, const std::vector<RankStatistics>& ranks)
{
    OutputFile file(path);
    CsvWriter csv(file,
                  "processes,process,frames,bodies,ghosts,pairs,work,came,sent_bytes,ghost_bytes,row_bytes,step_ms,"
                  "wait_ms,memory_bytes");
    for (std::size_t rank = 0; rank < ranks.size(); ++rank) {
        const RankStatistics& r = ranks[rank];
        csv.row(ranks.size(), rank, r.frames, r.bodies, r.ghosts, r.pairs, r.work, r.came, r.sent_bytes, r.ghost_bytes,
                r.row_bytes, Fixed{r.step_ms, 3}, Fixed{r.wait_ms, 3}, r.peak_memory);
    }
    file.commit();
}

void write_rank_trace(const std::filesystem::path& path, const std::string& title,
                      const std::vector<std::vector<RankPhase>>& ranks)
{
    OutputFile file(path);
    JsonWriter json(file);
    const auto name = [&](std::string_view what, std::string_view named, const auto&... thread) {
        json.line(),
            json.object("ph", "M", "pid", 1, thread..., "name", what, "args", [&] { json.object("name", named); });
    };
    json.begin_object(), json.schema("oncollide.trace", 1);
    json.members("displayTimeUnit", "ms");
    json.key("traceEvents"), json.begin_array();
    name("process_name", title);
    for (std::size_t rank = 0; rank < ranks.size(); ++rank) {
        name("thread_name", fmt::format("process {}", rank), "tid", rank);
        for (const RankPhase& phase : ranks[rank]) {
            json.line();
            json.object("ph", "X", "pid", 1, "tid", rank, "name", phase_names[phase.kind], "ts",
                        Fixed{phase.begin_us, 3}, "dur", Fixed{phase.end_us - phase.begin_us, 3}, "args",
                        [&] { json.object("frame", phase.frame); });
        }
    }
    json.line(), json.end_array();
    json.end_object();
    file.write("\n");
    file.commit();
}

} // namespace oncollide
