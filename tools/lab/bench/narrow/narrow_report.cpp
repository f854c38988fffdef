#include "bench/narrow/narrow_report.hpp"

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/motion.hpp>

#include "common/line_plot.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

using Group = Group;

constexpr double distance_tolerance = 1e-6; // relative to the diagonal; FCL rounds by about 1e-9

bool took_part(const NarrowRow& row, NarrowQuery query)
{
    return row.queries[std::size_t(query)].has_value();
}

/// The reference of the ratios: FCL's OBBRSS, in its usual form. Null if it did not take part.
const NarrowRow* yardstick(const NarrowResult& result)
{
    for (const NarrowRow& row : result.rows)
        if (row.contender->name == "fcl-obbrss") return &row;
    return nullptr;
}

double ratio(const NarrowResult& result, const NarrowSummary& own, NarrowQuery query, std::size_t group,
             double NarrowSummary::*part)
{
    const NarrowRow* fcl = yardstick(result);
    return fcl && took_part(*fcl, query) && own.*part > 0 ? summarise(result, *fcl, query, group).*part / own.*part : 0;
}

std::string result_text(const NarrowSummary& s, NarrowQuery query)
{
    if (query == NarrowQuery::distance)
        return s.error <= distance_tolerance ? "ok" : fmt::format("off by {:.2g} %", 100 * s.error);
    std::string text = s.missed ? fmt::format("MISSED {}", s.missed) : "";
    if (s.extra) text += fmt::format("{}+{}", text.empty() ? "" : " ", s.extra);
    return text.empty() ? "ok" : text;
}

std::string_view name_of(Promise promise)
{
    constexpr std::string_view names[] = {"exact", "conservative", "approximate"};
    return names[int(promise)];
}

void print_contenders(const NarrowResult& result)
{
    say("\n  {:<16}{:>10}{:>12}{:>9}  {:<14}\n", "", "build ms", "warm-up ms", "MB", "promises");
    for (const NarrowRow& row : result.rows)
        say("  {:<16}{:>10.2f}{:>12.1f}{:>9}  {:<14}{}\n", row.contender->name, row.build_ms, row.warm_up_ms,
            row.bytes < 1e5 ? "-" : fmt::format("{:.1f}", row.bytes / 1e6), name_of(row.contender->promise),
            row.contender->what);
    for (const NarrowRow& row : result.rows)
        if (!row.figures.empty()) say("  {:<16}{}\n", row.contender->name, row.figures);
}

/// Three digits: times are not more precise.
std::string microseconds(double us)
{
    return us >= 99.95   ? fmt::format("{:.0f}", us)
           : us >= 9.995 ? fmt::format("{:.1f}", us)
                         : fmt::format("{:.2f}", us);
}

void print_query(const NarrowResult& result, NarrowQuery query)
{
    say("\n{}, microseconds: median at each distance; over all poses\n  {:<16}", query_names[std::size_t(query)], "");
    std::vector<std::size_t> widths;
    for (const std::string& group : result.workload.groups) {
        widths.push_back(std::max<std::size_t>(9, group.size() + 2));
        say("{:>{}}", group, widths.back());
    }
    say("  |{:>9}{:>9}{:>11}{:>10}{:>9}{:>12}{:>10}{:>10}  {:<14}{}\n", "median", "mean", "colliding", "separate",
        "in loop", "RSS/median", "RSS/mean", "RSS/loop", "results", "hash");
    for (const NarrowRow& row : result.rows) {
        if (!took_part(row, query)) continue;
        say("  {:<16}", row.contender->name);
        for (std::size_t group = 0; group < result.workload.groups.size(); ++group)
            say("{:>{}}", microseconds(summarise(result, row, query, group).median), widths[group]);
        const NarrowSummary s = summarise(result, row, query);
        say("  |{:>9}{:>9}{:>11}{:>10}{:>9}{:>12.2f}{:>10.2f}{:>10.2f}  {:<14}{:016x}\n", microseconds(s.median),
            microseconds(s.mean), s.colliding ? microseconds(s.mean_colliding) : "-",
            s.colliding < s.poses ? microseconds(s.mean_separate) : "-", microseconds(s.in_loop),
            ratio(result, s, query, every_group, &NarrowSummary::median),
            ratio(result, s, query, every_group, &NarrowSummary::mean),
            ratio(result, s, query, every_group, &NarrowSummary::in_loop), result_text(s, query), s.hash);
    }
}

} // namespace

NarrowSummary summarise(const NarrowResult& result, const NarrowRow& row, NarrowQuery query, std::size_t group)
{
    const QueryResult& own = *row.queries[std::size_t(query)];
    NarrowSummary summary;
    std::vector<double> all, colliding, separate;
    for (std::size_t i = 0; i < own.us.size(); ++i) {
        if (group != every_group && result.workload.poses[i].group != group) continue;
        all.push_back(own.us[i]);
        (result.truth.colliding[i] ? colliding : separate).push_back(own.us[i]);
        summary.hash = splitmix(summary.hash ^ own.hashes[i]);
        if (query == NarrowQuery::distance)
            summary.error = std::max(summary.error, own.errors[i] / result.diagonal);
        else
            summary.missed += own.missed[i], summary.extra += own.extra[i];
    }
    summary.median = median(all), summary.mean = mean(all);
    summary.mean_colliding = mean(colliding), summary.mean_separate = mean(separate);
    summary.poses = all.size(), summary.colliding = colliding.size();
    std::vector<double> loops;
    for (const NarrowPose& pose : result.workload.poses)
        if (group == every_group || pose.group == group) loops.push_back(own.loop_us[pose.group]);
    summary.in_loop = mean(loops);
    return summary;
}

bool broken_promise(const NarrowResult& result)
{
    for (const NarrowRow& row : result.rows) {
        if (row.contender->group != Group::oncollide) continue;
        for (NarrowQuery query : result.queries) {
            if (!took_part(row, query)) continue;
            const NarrowSummary s = summarise(result, row, query);
            const bool exact = row.contender->promise == Promise::exact;
            if (s.missed || (exact && (s.extra || s.error > distance_tolerance))) return true;
        }
    }
    return false;
}

void print_narrow(const NarrowResult& result)
{
    print_contenders(result);
    for (NarrowQuery query : result.queries) print_query(result, query);
    say("\n");
    for (const std::string& note : result.truth.notes) say("checked by {}\n", note);
}

void write_narrow_csv(OutputFile& file, const NarrowResult& result)
{
    CsvWriter csv(file,
                  "mesh_a,triangles_a,mesh_b,triangles_b,seed,ask,distance,poses,colliding,contender,library,promise,"
                  "median_us,mean_us,mean_colliding_us,mean_separate_us,ratio_median,ratio_mean,missed,extra,error,"
                  "hash,build_ms,warm_up_ms,bytes,loop_us,ratio_loop");
    for (std::size_t group = 0; group < result.workload.groups.size(); ++group)
        for (NarrowQuery query : result.queries)
            for (const NarrowRow& row : result.rows) {
                if (!took_part(row, query)) continue;
                const NarrowSummary s = summarise(result, row, query, group);
                const auto short_of = [](double x) { return Digits{x, 4}; };
                csv.row(result.mesh_a, result.triangles_a, result.mesh_b, result.triangles_b, result.seed,
                        query_names[std::size_t(query)], result.workload.groups[group], s.poses, s.colliding,
                        row.contender->name, Quoted{row.contender->what}, name_of(row.contender->promise),
                        short_of(s.median), short_of(s.mean), short_of(s.mean_colliding), short_of(s.mean_separate),
                        short_of(ratio(result, s, query, group, &NarrowSummary::median)),
                        short_of(ratio(result, s, query, group, &NarrowSummary::mean)), s.missed, s.extra,
                        Digits{s.error, 3}, Hex{s.hash}, short_of(row.build_ms), short_of(row.warm_up_ms),
                        std::uint64_t(row.bytes), short_of(s.in_loop),
                        short_of(ratio(result, s, query, group, &NarrowSummary::in_loop)));
            }
}

void write_poses_csv(OutputFile& file, const NarrowResult& result)
{
    const auto title = [](const std::string& name) {
        if (!name.starts_with("walk-")) return name == "fcl-obb" ? std::string("FCL OBB") : "FCL OBBRSS";
        const std::size_t end = std::min(name.find('+'), name.size());
        return fmt::format("depth {}{}", name.substr(5, end - 5), end < name.size() ? " + fcl" : "");
    };
    std::string header = "pose,colliding,triangle_pairs";
    for (const NarrowRow& row : result.rows) header += fmt::format(",{} us", title(row.contender->name));
    CsvWriter csv(file, header);
    std::vector<std::size_t> order(result.workload.poses.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[result.workload.poses[i].number] = i;
    for (const std::size_t i : order) {
        const NarrowPose& pose = result.workload.poses[i];
        csv.add(pose.number, int(result.truth.colliding[i]), pose.known.triangle_pairs);
        for (const NarrowRow& row : result.rows)
            csv.add(Fixed{row.queries[std::size_t(NarrowQuery::boolean)]->us[i], 3});
        csv.end_row();
    }
}

void draw_narrow_plot(OutputFile& file, const NarrowResult& result)
{
    std::vector<PlotPanel> panels;
    for (NarrowQuery query : result.queries) {
        PlotPanel panel{fmt::format("{}: {} and {}", query_names[std::size_t(query)], result.mesh_a, result.mesh_b),
                        {}};
        for (std::size_t k = 0; k < result.rows.size(); ++k) {
            const NarrowRow& row = result.rows[k];
            if (!took_part(row, query)) continue;
            using Weight = PlotLine::Weight;
            const bool own = row.contender->group == Group::oncollide;
            PlotLine line{own ? Weight::main : Weight::peer, row.contender->name, {}, k};
            for (std::size_t group = 0; group < result.workload.groups.size(); ++group)
                line.points.push_back(
                    {double(group), std::max(summarise(result, row, query, group).median, 1e-2)}); // no log of 0
            panel.lines.push_back(std::move(line));
        }
        panels.push_back(std::move(panel));
    }
    draw_line_plot(file, panels,
                   {"distance, % of the diagonal of the first mesh", "microseconds, median",
                    [](double us) { return plain_measure(us, 3) + " us"; }, result.workload.groups});
}

} // namespace oncollide::tools
