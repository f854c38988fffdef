#include "bench/narrow/narrow_report.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/motion.hpp>

#include "bench/common/result_table.hpp"
#include "common/line_plot.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

constexpr double distance_tolerance = 1e-6; // relative to the diagonal; FCL rounds by about 1e-9

bool took_part(const NarrowRow& row, NarrowQuery query)
{
    return row.queries[std::size_t(query)].has_value();
}

/// A contender's results for one kind of query over some poses, in microseconds.
struct NarrowSummary {
    double median = 0, mean = 0, mean_colliding = 0, mean_separate = 0;
    double in_loop = 0; ///< mean in a loop over all poses, microseconds as the others
    std::uint64_t poses = 0, colliding = 0;
    std::uint64_t missed = 0, extra = 0; ///< poses; for `all`: pairs of triangles
    double error = 0;                    ///< largest error of a distance, relative to the diagonal
    std::uint64_t hash = 0;              ///< of all results
};

constexpr std::size_t every_group = ~std::size_t{0};

NarrowSummary summarise(const NarrowResult& result, const NarrowRow& row, NarrowQuery query,
                        std::size_t group = every_group)
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

void append(Figures& to, const Figures& more)
{
    to.insert(to.end(), more.begin(), more.end());
}

Figures times_of(const NarrowResult& result, const NarrowSummary& s, NarrowQuery query, std::size_t group)
{
    const auto to_fcl = [&](double NarrowSummary::*part) { return ratio(result, s, query, group, part); };
    return figures("median_us", s.median, "mean_us", s.mean, "mean_colliding_us", s.mean_colliding, "mean_separate_us",
                   s.mean_separate, "loop_us", s.in_loop, "ratio_median", to_fcl(&NarrowSummary::median), "ratio_mean",
                   to_fcl(&NarrowSummary::mean), "ratio_loop", to_fcl(&NarrowSummary::in_loop));
}

void print_contenders(const NarrowResult& result)
{
    ResultTable table({}, {16, 14});
    say("\n");
    for (const NarrowRow& row : result.rows)
        table.print(figures("contender", row.contender->name, "build_ms", row.build_ms, "warm_up_ms", row.warm_up_ms,
                            "bytes", std::uint64_t(row.bytes), "promises", name_of(row.contender->promise), "what",
                            row.contender->what));
    for (const NarrowRow& row : result.rows)
        if (!row.figures.empty()) say("  {:<16}{}\n", row.contender->name, row.figures);
}

void print_query(const NarrowResult& result, NarrowQuery query)
{
    ResultTable table({}, {16});
    table.section(fmt::format("{}, microseconds: median at each distance; over all poses; ratios: FCL's OBBRSS",
                              query_names[std::size_t(query)]));
    for (const NarrowRow& row : result.rows) {
        if (!took_part(row, query)) continue;
        Figures line = figures("contender", row.contender->name);
        for (std::size_t group = 0; group < result.workload.groups.size(); ++group)
            line.emplace_back(result.workload.groups[group], summarise(result, row, query, group).median);
        const NarrowSummary s = summarise(result, row, query);
        append(line, times_of(result, s, query, every_group));
        append(line, figures("results", result_text(s, query), "hash", Hex{s.hash}));
        table.print(line);
    }
}

} // namespace

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

void write_narrow_csv(const std::string& file, const std::string& line, const NarrowResult& result)
{
    ResultTable table(file, {}, line);
    for (std::size_t group = 0; group < result.workload.groups.size(); ++group)
        for (NarrowQuery query : result.queries)
            for (const NarrowRow& row : result.rows) {
                if (!took_part(row, query)) continue;
                const NarrowSummary s = summarise(result, row, query, group);
                Figures all = figures("mesh_a", result.mesh_a, "triangles_a", result.triangles_a, "mesh_b",
                                      result.mesh_b, "triangles_b", result.triangles_b, "seed", result.seed, "ask",
                                      query_names[std::size_t(query)], "distance", result.workload.groups[group],
                                      "poses", s.poses, "colliding", s.colliding, "contender", row.contender->name,
                                      "library", row.contender->what, "promise", name_of(row.contender->promise));
                append(all, times_of(result, s, query, group));
                append(all,
                       figures("missed", s.missed, "extra", s.extra, "error", s.error, "hash", Hex{s.hash}, "build_ms",
                               row.build_ms, "warm_up_ms", row.warm_up_ms, "bytes", std::uint64_t(row.bytes)));
                table.row({}, all);
            }
    table.commit();
}

void write_poses_csv(const std::string& file, const NarrowResult& result)
{
    const auto title = [](const std::string& name) {
        if (!name.starts_with("walk-")) return name == "fcl-obb" ? std::string("FCL OBB") : "FCL OBBRSS";
        const std::size_t end = std::min(name.find('+'), name.size());
        return fmt::format("depth {}{}", name.substr(5, end - 5), end < name.size() ? " + fcl" : "");
    };
    std::vector<std::size_t> order(result.workload.poses.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[result.workload.poses[i].number] = i;
    ResultTable table(file);
    for (const std::size_t i : order) {
        const NarrowPose& pose = result.workload.poses[i];
        Figures all = figures("pose", pose.number, "colliding", bool(result.truth.colliding[i]), "triangle_pairs",
                              pose.known.triangle_pairs);
        for (const NarrowRow& row : result.rows)
            all.emplace_back(fmt::format("{} us", title(row.contender->name)),
                             row.queries[std::size_t(NarrowQuery::boolean)]->us[i]);
        table.row({}, all);
    }
    table.commit();
}

void draw_narrow_plot(const std::string& path, const NarrowResult& result)
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
    OutputFile file(path);
    draw_line_plot(file, panels,
                   {"distance, % of the diagonal of the first mesh", "microseconds, median",
                    [](double us) { return plain_measure(us, 3) + " us"; }, result.workload.groups});
    file.commit();
}

} // namespace oncollide::tools
