#include <oncollide/pipeline/ranks/ranked_report.hpp>

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/output_file.hpp>
#include <oncollide/pipeline/report_kept.hpp>

namespace oncollide {

namespace {

constexpr std::size_t most_lines = 32;
constexpr std::string_view phase_names[] = {"move", "exchange", "step", "results"};

struct Column {
    const char* name;
    double (*value)(const RankStatistics&);
    bool bytes = false;
};
double mean_per_frame(double sum, const RankStatistics& r)
{
    return r.frames ? sum / double(r.frames) : 0;
}
const Column columns[] = {
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
    for (const Column& column : columns) {
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
    for (const Column& column : columns) text += fmt::format(" {:>11}", column.name);
    text += "   mean per frame\n";
    if (ranks.size() <= most_lines) {
        for (std::size_t rank = 0; rank < ranks.size(); ++rank)
            text += line(fmt::format("{}", rank), [&](const Column& column) { return column.value(ranks[rank]); });
    } else {
        const auto over_ranks = [&](auto take) {
            return [&, take](const Column& column) {
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
    file.print(
        "processes,process,frames,bodies,ghosts,pairs,work,came,sent_bytes,ghost_bytes,row_bytes,step_ms,wait_ms,"
        "memory_bytes\n");
    for (std::size_t rank = 0; rank < ranks.size(); ++rank) {
        const RankStatistics& r = ranks[rank];
        file.print("{},{},{},{},{},{},{},{},{},{},{},{:.3f},{:.3f},{}\n", ranks.size(), rank, r.frames, r.bodies,
                   r.ghosts, r.pairs, r.work, r.came, r.sent_bytes, r.ghost_bytes, r.row_bytes, r.step_ms, r.wait_ms,
                   r.peak_memory);
    }
    file.commit();
}

void write_rank_trace(const std::filesystem::path& path, const std::string& title,
                      const std::vector<std::vector<RankPhase>>& ranks)
{
    OutputFile file(path);
    file.print("{{\"displayTimeUnit\": \"ms\", \"traceEvents\": [\n"
               "{{\"ph\": \"M\", \"pid\": 1, \"name\": \"process_name\", \"args\": {{\"name\": {}}}}}",
               nlohmann::json(title).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    for (std::size_t rank = 0; rank < ranks.size(); ++rank) {
        file.print(",\n{{\"ph\": \"M\", \"pid\": 1, \"tid\": {0}, \"name\": \"thread_name\", \"args\": {{\"name\": "
                   "\"process {0}\"}}}}",
                   rank);
        for (const RankPhase& phase : ranks[rank])
            file.print(
                ",\n{{\"ph\": \"X\", \"pid\": 1, \"tid\": {}, \"name\": \"{}\", \"ts\": {:.3f}, \"dur\": {:.3f}, "
                "\"args\": {{\"frame\": {}}}}}",
                rank, phase_names[phase.kind], phase.begin_us, phase.end_us - phase.begin_us, phase.frame);
    }
    file.print("\n]}}\n");
    file.commit();
}

} // namespace oncollide
