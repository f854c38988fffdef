#include "study/report.hpp"

#include <algorithm>
#include <cmath>

#include <oncollide/base/text/svg.hpp>

#include "common/line_plot.hpp"
#include "common/text.hpp"

namespace oncollide::tools {
namespace {

/// A row of bars, one per column, each with its number.
struct BarRow {
    std::string name;
    std::vector<double> lengths; ///< 0 to 1
    std::vector<std::string> texts;
};

constexpr double bars_width = 960, bars_left = 310, row_height = 22, head = 34;

void draw_bars(OutputFile& file, std::string_view title, const std::vector<std::string>& columns,
               const std::vector<BarRow>& rows)
{
    const double height = head + row_height * double(rows.size()) + 4,
                 pitch = (bars_width - bars_left) / double(columns.size());
    const double room = std::min(46.0, 0.5 * pitch); // for a number
    Svg svg(file);
    svg.begin_inline(bars_width, height, title);
    for (std::size_t k = 0; k < columns.size(); ++k)
        svg.text(bars_left + pitch * double(k), 16, Svg::Anchor::start, "head", columns[k]);
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const double y = head + row_height * double(r);
        if (r % 2 == 0) svg.rectangle(0, y - 3, bars_width, row_height, "band");
        svg.text(bars_left - 12, y + 12, Svg::Anchor::end, "name", rows[r].name);
        for (std::size_t k = 0; k < columns.size(); ++k) {
            const double x = bars_left + pitch * double(k), length = rows[r].lengths[k] * (pitch - room - 8);
            svg.rectangle(x, y, length, 14, "bar");
            svg.text(x + length + 4, y + 12, Svg::Anchor::start, "number", rows[r].texts[k]);
        }
    }
    svg.end();
}

/// The series, in order of their first row, with their rows.
std::vector<std::pair<std::string, std::vector<const StudyRow*>>> by_series(const Study& study)
{
    std::vector<std::pair<std::string, std::vector<const StudyRow*>>> result;
    for (const StudyRow& row : study.rows) {
        auto at = std::ranges::find(result, row.variant.series, [](const auto& s) { return s.first; });
        if (at == result.end()) at = result.insert(at, {row.variant.series, {}});
        at->second.push_back(&row);
    }
    return result;
}

PlotLine line_of(std::string label, std::vector<PlotLine::Point> points, std::size_t style, PlotLine::Weight weight)
{
    std::ranges::sort(points, {}, &PlotLine::Point::x);
    return {weight, std::move(label), std::move(points), style};
}

} // namespace

void draw_speed_error(OutputFile& file, const Study& study)
{
    double least = 1e300;
    for (const StudyRow& row : study.rows)
        if (row.error > 0) least = std::min(least, row.error);
    // Exact results have no logarithm: they are drawn a decade to the left of the others.
    const double exact = least < 1e300 ? std::pow(10, std::floor(std::log10(least)) - 1) : 1;
    const auto point = [&](const StudyRow& row) {
        return PlotLine::Point{row.error > 0 ? row.error : exact, study.mean_ms(row.ms)};
    };
    PlotPanel panel{study.title + ": speed against error", {}};
    std::vector<PlotLine::Point> front;
    for (const auto& [series, rows] : by_series(study)) {
        std::vector<PlotLine::Point> points;
        for (const StudyRow* row : rows) {
            points.push_back(point(*row));
            if (on_front(study, *row)) front.push_back(points.back());
        }
        panel.lines.push_back(line_of(series, std::move(points), panel.lines.size(), PlotLine::Weight::main));
    }
    for (const StudyPeer& peer : study.peers) {
        const PlotLine::Point at{exact, study.mean_ms(peer.ms)};
        if (on_front(study, peer)) front.push_back(at);
        const std::string label = peer.right() ? peer.name : peer.name + ", not error-free";
        panel.lines.push_back(line_of(label, {at}, panel.lines.size(), PlotLine::Weight::peer));
    }
    if (front.size() > 1)
        panel.lines.push_back(
            line_of("fastest at its error", std::move(front), panel.lines.size(), PlotLine::Weight::baseline));
    draw_line_plot(file, {&panel, 1},
                   {.x_label = "certified error, m (logarithmic)",
                    .y_label = "ms per frame, mean (logarithmic)",
                    .value_text = [](double ms) { return fmt::format("{:.3g} ms", ms); },
                    .x_least_name = "exact"});
}

void draw_stage_times(OutputFile& file, const Study& study)
{
    std::vector<BarRow> rows;
    double most = 1e-12;
    for (const StudyRow& row : study.rows) {
        BarRow& bar = rows.emplace_back(BarRow{row.variant.name, std::vector<double>(5), {}});
        const std::size_t from = std::size_t(study.warm_up), count = row.stage_ms.size() - from;
        for (std::size_t frame = from; frame < row.stage_ms.size(); ++frame)
            for (std::size_t k = 0; k < 5; ++k) bar.lengths[k] += row.stage_ms[frame][k] / double(count);
        for (double ms : bar.lengths) bar.texts.push_back(fmt::format("{:.3g}", ms)), most = std::max(most, ms);
    }
    for (BarRow& row : rows)
        for (double& length : row.lengths) length /= most;
    std::vector<std::string> columns;
    for (const StageStats& stage : study.rows.front().stages) columns.push_back(fmt::format("{}, ms", stage.stage));
    draw_bars(file, "time by stage", columns, rows);
}

void draw_funnel(OutputFile& file, const Study& study)
{
    std::vector<BarRow> rows;
    double most = 1;
    for (const StudyRow& row : study.rows) {
        const auto left = [&](Verdict v) { return double(row.verdicts[std::size_t(v)]); };
        const double pairs = double(row.stages[2].out), apart = left(Verdict::separate);
        const double wide = left(Verdict::within) + left(Verdict::undecided), sure = left(Verdict::colliding);
        const double frames = double(study.frames), bodies = double(study.bodies);
        BarRow& bar = rows.emplace_back(BarRow{row.variant.name,
                                               {bodies * (bodies - 1) / 2, pairs / frames, apart / frames,
                                                double(row.stages[3].out) / frames, wide / frames, sure / frames},
                                               {}});
        for (double n : bar.lengths) most = std::max(most, n), bar.texts.push_back(fmt::format("{:.4g}", n));
    }
    for (BarRow& row : rows)
        for (double& length : row.lengths) length = std::log10(1 + length) / std::log10(1 + most);
    draw_bars(file, "stage funnel",
              {"all pairs", "after broad", "certified apart", "after refine", "left within", "left colliding"}, rows);
}

void draw_false_positives(OutputFile& file, const Study& study)
{
    std::vector<BarRow> rows;
    for (const StudyRow& row : study.rows) {
        if (!row.false_positives) continue;
        BarRow& bar =
            rows.emplace_back(BarRow{fmt::format("{}: {}", row.variant.name, grouped(row.false_positives)), {}, {}});
        for (std::uint64_t count : row.false_positives_by_share) {
            const double share = double(count) / double(row.false_positives);
            bar.lengths.push_back(share), bar.texts.push_back(count ? fmt::format("{:.0f} %", 100 * share) : "");
        }
    }
    std::vector<std::string> columns;
    for (std::size_t k = 0; k < false_positive_bins; ++k)
        columns.push_back(fmt::format("{}-{} %", 10 * k, 10 * (k + 1)));
    draw_bars(file, "true distance of the false positives relative to their bound", columns, rows);
}

} // namespace oncollide::tools
