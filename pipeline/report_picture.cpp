// The picture of a run: on top, the number of bodies and pairs that each stage receives and passes on; below, the time
// of every frame by stage. Plain SVG, readable on a light page and in print.
#include <oncollide/pipeline/report_kept.hpp>

#include <oncollide/base/output_file.hpp>
#include <oncollide/base/printable.hpp>

#include <algorithm>
#include <cmath>

namespace oncollide {
namespace {

constexpr double width = 960, left = 130, right = 930;
constexpr double funnel_top = 92, row_height = 40;
constexpr double chart_height = 230;
// Okabe and Ito's palette, distinguishable with any colour vision.
constexpr std::string_view colours[] = {"#0072b2", "#56b4e9", "#009e73", "#e69f00", "#cc79a7", "#d55e00"};

std::string_view colour(std::size_t stage)
{
    return colours[stage % std::size(colours)];
}

std::string escaped(std::string_view text)
{
    std::string result;
    for (const char c : printable(text)) {
        if (c == '<')
            result += "&lt;";
        else if (c == '>')
            result += "&gt;";
        else if (c == '&')
            result += "&amp;";
        else
            result += c;
    }
    return result;
}

enum class Anchor { start, middle, end };

void text(OutputFile& file, double x, double y, Anchor anchor, std::string_view style, std::string_view words)
{
    constexpr std::string_view names[] = {"start", "middle", "end"};
    file.print("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" class=\"{}\">{}</text>\n", x, y, names[int(anchor)],
               style, escaped(words));
}

void rectangle(OutputFile& file, double x, double y, double w, double h, std::string_view fill, double opacity = 1)
{
    file.print("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\" fill-opacity=\"{}\"/>\n",
               x, y, std::max(w, 0.0), std::max(h, 0.0), fill, opacity);
}

void line(OutputFile& file, double x1, double y1, double x2, double y2, std::string_view style)
{
    file.print("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>\n", x1, y1, x2, y2, style);
}

/// A count that may be a mean over frames.
std::string count_text(double value)
{
    return value == std::floor(value) || value >= 1000 ? fmt::format("{:.0f}", value) : fmt::format("{:.1f}", value);
}

/// The tick distance of an axis with about `ticks` ticks up to `top`: 1, 2 or 5 times a power of ten.
double nice_step(double top, int ticks)
{
    const double power = std::pow(10, std::floor(std::log10(top / ticks)));
    for (double factor : {1.0, 2.0, 5.0})
        if (factor * power * ticks >= top) return factor * power;
    return 10 * power;
}

void draw_funnel(OutputFile& file, std::span<const StageStats> stages, double bottom)
{
    text(file, 20, funnel_top - 24, Anchor::start, "heading", "Input (pale) and output (full) of each stage");
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
        line(file, x_of(n), funnel_top - 8, x_of(n), bottom, decade < 0 ? "axis" : "grid");
        text(file, x_of(n), bottom + 15, Anchor::middle, "tick", fmt::format("{:.0f}", n));
    }
    text(file, (left + bar_right) / 2, bottom + 33, Anchor::middle, "label",
         "bodies or pairs, mean per frame (logarithmic)");
    for (std::size_t k = 0; k < stages.size(); ++k) {
        const StageStats& s = stages[k];
        const double y = funnel_top + row_height * double(k), frames = std::max<double>(1, double(s.frames));
        const double in = double(s.in) / frames, out = double(s.out) / frames;
        text(file, left - 10, y + 15, Anchor::end, "stage", s.stage);
        text(file, left - 10, y + 28, Anchor::end, "tick", s.unit);
        if (!s.skipped) {
            rectangle(file, left, y, x_of(in) - left, 13, colour(k), 0.35);
            rectangle(file, left, y + 14, x_of(out) - left, 13, colour(k));
        }
        std::string words = fmt::format("{} in, {} out", count_text(in), count_text(out));
        if (s.skipped) words = "skipped";
        text(file, bar_right + 12, y + 12, Anchor::start, "value", words);
        if (s.skipped)
            text(file, left + 10, y + 17, Anchor::start, "value", s.note.empty() ? "skipped by request" : s.note);
        else
            text(file, bar_right + 12, y + 26, Anchor::start, "tick",
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

void draw_times(OutputFile& file, std::span<const StageStats> stages, const StageTimes& times, double chart_top)
{
    text(file, 20, chart_top - 42, Anchor::start, "heading", "Time of each frame by stage");
    double x = 20;
    for (std::size_t k = 0; k < stages.size(); ++k) {
        rectangle(file, x, chart_top - 30, 11, 11, colour(k));
        const std::string words = fmt::format("{} {:.3f} ms", stages[k].stage,
                                              stages[k].cpu_ms / std::max<double>(1, double(stages[k].frames)));
        text(file, x + 16, chart_top - 20, Anchor::start, "value", words);
        x += 36 + 7.0 * double(words.size());
    }
    const std::vector<Column> columns = times.columns(200);
    const std::size_t frames = times.frames();
    const double top = axis_top(columns), bottom = chart_top + chart_height, step = nice_step(top, 5);
    const auto y_of = [&](double ms) { return bottom - chart_height * std::min(ms, top) / top; };
    for (double ms = 0; ms <= top * 1.0001; ms += step) {
        line(file, left - 60, y_of(ms), right, y_of(ms), ms == 0 ? "axis" : "grid");
        text(file, left - 66, y_of(ms) + 4, Anchor::end, "tick", fmt::format("{:g}", std::round(ms / step) * step));
    }
    file.print("<text transform=\"translate(18 {:.1f}) rotate(-90)\" text-anchor=\"middle\" class=\"label\">ms per "
               "frame</text>\n",
               (chart_top + bottom) / 2);
    const double x0 = left - 60, pitch = (right - x0) / double(std::max<std::size_t>(1, columns.size()));
    const double bar = std::min(pitch * (pitch > 6 ? 0.85 : 1.0), 60.0);
    double last_note = -1e9; // x of the last note; a note is about 60 wide
    for (std::size_t c = 0; c < columns.size(); ++c) {
        double below = 0;
        const double at = x0 + pitch * (double(c) + 0.5);
        for (std::size_t k = 0; k < stages.size(); ++k) {
            const double y_top = y_of(below + columns[c].ms[k]);
            if (y_of(below) - y_top > 0.004) rectangle(file, at - bar / 2, y_top, bar, y_of(below) - y_top, colour(k));
            below += columns[c].ms[k];
        }
        if (below > top && at - last_note > 64) {
            const double shifted = std::clamp(at, x0 + 30, right - 30);
            text(file, shifted, chart_top - 4, Anchor::middle, "tick", fmt::format("↑ {:.3g} ms", below));
            last_note = at;
        }
    }
    const double frame_step = std::max(1.0, nice_step(double(frames), 12));
    for (double frame = 0; frame < double(frames); frame += frame_step)
        text(file, x0 + pitch * (frame * double(columns.size()) / double(frames) + 0.5), bottom + 16, Anchor::middle,
             "tick", fmt::format("{:.0f}", frame));
    text(file, (x0 + right) / 2, bottom + 34, Anchor::middle, "label", "frame");
}

} // namespace

void Report::write_picture(const std::filesystem::path& path) const
{
    const std::span<const StageStats> stages = totals_;
    const double funnel_bottom = funnel_top + row_height * double(stages.size());
    const double chart_top = funnel_bottom + 108, height = chart_top + chart_height + 78;
    const std::array<std::uint64_t, 4> counts = verdicts();

    OutputFile file(path);
    file.print(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1:.0f}\" viewBox=\"0 0 {0} {1:.0f}\">\n",
        width, height);
    file.print("<style>text{{font-family:'DejaVu Sans',Verdana,Helvetica,Arial,sans-serif;font-size:12px;fill:#222}}"
               ".title{{font-size:17px;font-weight:bold}}.heading{{font-size:14px;font-weight:bold}}"
               ".stage{{font-weight:bold}}.tick{{font-size:11px;fill:#555}}.label{{fill:#333}}"
               ".grid{{stroke:#e2e2e2}}.axis{{stroke:#666}}</style>\n");
    rectangle(file, 0, 0, width, height, "#ffffff");
    text(file, 20, 30, Anchor::start, "title", title());
    text(file, 20, height - 14, Anchor::start, "tick",
         fmt::format("Over all frames: {} colliding, {} within, {} undecided, {} separate pairs. Result hash {:016x}.",
                     counts[int(Verdict::colliding)], counts[int(Verdict::within)], counts[int(Verdict::undecided)],
                     counts[int(Verdict::separate)], hash_));
    draw_funnel(file, stages, funnel_bottom);
    draw_times(file, stages, kept_->stage_times, chart_top);
    file.print("</svg>\n");
    file.commit();
}

} // namespace oncollide
