// The picture of a run: on top, the number of bodies and pairs that each stage receives and passes on; below, the time
// of every frame by stage. Plain SVG, readable on a light page and in print.
#include <oncollide/runs/report_kept.hpp>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/text/plain_number.hpp>
#include <oncollide/base/text/svg.hpp>

#include <algorithm>
#include <cmath>

namespace oncollide {
namespace {

constexpr double width = 960, left = 130, right = 930;
constexpr double funnel_top = 92, row_height = 40;
constexpr double chart_height = 230;

using Anchor = Svg::Anchor;

/// A count that may be a mean over frames.
std::string count_text(double value)
{
    return value == std::floor(value) || value >= 1000 ? fmt::format("{:.0f}", value) : fmt::format("{:.1f}", value);
}

void draw_funnel(Svg& svg, std::span<const StageStats> stages, double bottom)
{
    svg.text(20, funnel_top - 24, Anchor::start, "heading", "Input (pale) and output (full) of each stage");
    double most = 10;
    for (const StageStats& s : stages)
        if (s.frames) most = std::max({most, double(s.in) / double(s.frames), double(s.out) / double(s.frames)});
    const double decades = std::ceil(std::log10(most));
    // The axis is log10(1 + count), so that a count of one is visible.
    const double bar_right = right - 190;
    const auto x_of = [&](double n) {
        return left + (bar_right - left) * std::log10(1 + n) / std::log10(1 + std::pow(10, decades));
    };

    for (double decade = -1; decade <= decades; ++decade) {
        const double n = decade < 0 ? 0 : std::pow(10, decade);
        svg.line(x_of(n), funnel_top - 8, x_of(n), bottom, decade < 0 ? "axis" : "grid");
        svg.text(x_of(n), bottom + 15, Anchor::middle, "tick", fmt::format("{:.0f}", n));
    }
    svg.text((left + bar_right) / 2, bottom + 33, Anchor::middle, "label",
             "bodies or pairs, mean per frame (logarithmic)");
    for (std::size_t k = 0; k < stages.size(); ++k) {
        const StageStats& s = stages[k];
        const double y = funnel_top + row_height * double(k), frames = std::max<double>(1, double(s.frames));
        const double in = double(s.in) / frames, out = double(s.out) / frames;
        svg.text(left - 10, y + 15, Anchor::end, "stage", s.stage);
        svg.text(left - 10, y + 28, Anchor::end, "tick", s.unit);
        if (!s.skipped) {
            svg.filled(left, y, x_of(in) - left, 13, plot_colour(k), 0.35);
            svg.filled(left, y + 14, x_of(out) - left, 13, plot_colour(k));
        }
        std::string words = fmt::format("{} in, {} out", count_text(in), count_text(out));
        if (s.skipped) words = "skipped";
        svg.text(bar_right + 12, y + 12, Anchor::start, "value", words);
        if (s.skipped)
            svg.text(left + 10, y + 17, Anchor::start, "value", s.note.empty() ? "skipped by request" : s.note);
        else
            svg.text(bar_right + 12, y + 26, Anchor::start, "tick",
                     fmt::format("{} culled, {} undecided", count_text(double(s.culled) / frames),
                                 count_text(double(s.undecided) / frames)));
    }
}

using Column = StageTimes::Column;

/// The top of the axis: the highest column, unless a few (cold frames) would flatten all others.
double axis_top(const std::vector<Column>& columns)
{
    std::vector<double> sums;
    for (const Column& column : columns) sums.push_back(column.sum);
    if (sums.empty()) return 1;
    std::sort(sums.begin(), sums.end());
    const double usual = sums[std::size_t(0.95 * double(sums.size() - 1))];
    const double top = sums.back() > 2.5 * usual && usual > 0 ? 1.3 * usual : sums.back();
    return std::max(top, 1e-4);
}

void draw_times(Svg& svg, std::span<const StageStats> stages, const StageTimes& times, double chart_top)
{
    svg.text(20, chart_top - 42, Anchor::start, "heading", "Time of each frame by stage");
    double x = 20;
    for (std::size_t k = 0; k < stages.size(); ++k) {
        svg.filled(x, chart_top - 30, 11, 11, plot_colour(k));
        const std::string words = fmt::format("{} {:.3f} ms", stages[k].stage,
                                              stages[k].cpu_ms / std::max<double>(1, double(stages[k].frames)));
        svg.text(x + 16, chart_top - 20, Anchor::start, "value", words);
        x += 36 + 7.0 * double(words.size());
    }
    const std::vector<Column> columns = times.columns(200);
    const std::size_t frames = times.frames();
    const double top = axis_top(columns), bottom = chart_top + chart_height, step = axis_step(top, 5);
    const auto y_of = [&](double ms) { return bottom - chart_height * std::min(ms, top) / top; };
    for (double ms = 0; ms <= top * 1.0001; ms += step) {
        svg.line(left - 60, y_of(ms), right, y_of(ms), ms == 0 ? "axis" : "grid");
        svg.text(left - 66, y_of(ms) + 4, Anchor::end, "tick", fmt::format("{:g}", std::round(ms / step) * step));
    }
    svg.vertical_text(18, (chart_top + bottom) / 2, "label", "ms per frame");
    const double x0 = left - 60, pitch = (right - x0) / double(std::max<std::size_t>(1, columns.size()));
    const double bar = std::min(pitch * (pitch > 6 ? 0.85 : 1.0), 60.0);
    double last_note = -1e9; // x of the last note; a note is about 60 wide
    for (std::size_t c = 0; c < columns.size(); ++c) {
        double below = 0;
        const double at = x0 + pitch * (double(c) + 0.5);
        for (std::size_t k = 0; k < stages.size(); ++k) {
            const double y_top = y_of(below + columns[c].ms[k]);
            if (y_of(below) - y_top > 0.004) svg.filled(at - bar / 2, y_top, bar, y_of(below) - y_top, plot_colour(k));
            below += columns[c].ms[k];
        }
        if (below > top && at - last_note > 64) {
            const double shifted = std::clamp(at, x0 + 30, right - 30);
            svg.text(shifted, chart_top - 4, Anchor::middle, "tick", fmt::format("↑ {} ms", plain_measure(below, 3)));
            last_note = at;
        }
    }
    const double frame_step = std::max(1.0, axis_step(double(frames), 12));
    for (double frame = 0; frame < double(frames); frame += frame_step)
        svg.text(x0 + pitch * (frame * double(columns.size()) / double(frames) + 0.5), bottom + 16, Anchor::middle,
                 "tick", fmt::format("{:.0f}", frame));
    svg.text((x0 + right) / 2, bottom + 34, Anchor::middle, "label", "frame");
}

} // namespace

void Report::write_picture(const std::filesystem::path& path) const
{
    const std::span<const StageStats> stages = totals_;
    const double funnel_bottom = funnel_top + row_height * double(stages.size());
    const double chart_top = funnel_bottom + 108, height = chart_top + chart_height + 78;
    const std::array<std::uint64_t, 4> counts = verdicts();

    OutputFile file(path);
    Svg svg(file);
    svg.begin_file(width, height, ".stage{font-weight:bold}");
    svg.text(20, 30, Anchor::start, "title", title());
    svg.text(
        20, height - 14, Anchor::start, "tick",
        fmt::format("Over all frames: {} colliding, {} within, {} undecided, {} separate pairs. Result hash {:016x}.",
                    counts[int(Verdict::colliding)], counts[int(Verdict::within)], counts[int(Verdict::undecided)],
                    counts[int(Verdict::separate)], hash_));
    draw_funnel(svg, stages, funnel_bottom);
    draw_times(svg, stages, kept_->stage_times, chart_top);
    svg.end();
    file.commit();
}

} // namespace oncollide
