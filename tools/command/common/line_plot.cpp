#include "common/line_plot.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <oncollide/base/text/svg.hpp>

namespace oncollide::tools {
namespace {

constexpr double least_width = 960, left = 76, right = 660, label_gap = 40;
constexpr double panel_height = 480, plot_top = 46, plot_bottom = 420;
constexpr std::string_view dashes[] = {"none", "7 3", "2 3", "10 3 2 3", "14 4"};
// Centred at (0, 0), about 8 wide.
constexpr std::string_view markers[] = {"M-4 0A4 4 0 1 0 4 0A4 4 0 1 0-4 0Z",
                                        "M-4-4H4V4H-4Z",
                                        "M0-5L5 4H-5Z",
                                        "M0-5L5 0L0 5L-5 0Z",
                                        "M0 5L5-4H-5Z",
                                        "M-4-4L4 4M-4 4L4-4",
                                        "M0-5V5M-5 0H5",
                                        "M-5-2H5V2H-5Z"};

using Anchor = Svg::Anchor;

/// A logarithmic axis over whole decades, or an axis of named positions.
struct Axis {
    double from = 0, to = 0;                 ///< pixels
    std::span<const std::string> names = {}; ///< x is 0, 1, 2, ... with these names
    double low = 1e300, high = -1e300;       ///< log10; with names, their numbers

    void add(double value)
    {
        low = std::min(low, names.empty() ? std::floor(std::log10(value)) : 0);
        high = std::max(high, names.empty() ? std::ceil(std::log10(value) - 1e-9) : double(names.size() - 1));
    }
    double at(double value) const { return at_tick(names.empty() ? std::log10(value) : value); }
    double at_tick(double tick) const { return from + (to - from) * (tick - low) / (high - low); }
};

/// 1,000 as 1k, 0.01 as 0.01.
std::string tick_text(double value)
{
    if (value >= 1e6) return fmt::format("{:g}M", value / 1e6);
    if (value >= 1e3) return fmt::format("{:g}k", value / 1e3);
    return fmt::format("{:g}", value);
}

void draw_axes(Svg& svg, const Axis& x, const Axis& y, const PlotAxes& axes)
{
    for (double tick = x.low; tick <= x.high; ++tick) {
        svg.line(x.at_tick(tick), y.from, x.at_tick(tick), y.to, tick == x.low ? "axis" : "grid");
        const bool named = !x.names.empty() && tick < double(x.names.size());
        if (tick == x.low && !axes.x_least_name.empty())
            svg.text(x.at_tick(tick), y.from + 17, Anchor::middle, "tick", axes.x_least_name);
        else if (x.names.empty() || named)
            svg.text(x.at_tick(tick), y.from + 17, Anchor::middle, "tick",
                     named ? x.names[std::size_t(tick)] : tick_text(std::pow(10, tick)));
    }
    for (double decade = y.low; decade <= y.high; ++decade) {
        const double value = std::pow(10, decade);
        svg.line(x.from, y.at(value), x.to, y.at(value), decade == y.low ? "axis" : "grid");
        svg.text(x.from - 8, y.at(value) + 4, Anchor::end, "tick", fmt::format("{:g}", value));
    }
    svg.text(0.5 * (x.from + x.to), y.from + 36, Anchor::middle, "label", axes.x_label);
    svg.vertical_text(18, 0.5 * (y.from + y.to), "label", axes.y_label);
}

/// Heights of the labels: at the lines' ends if there is room, otherwise moved apart.
std::vector<double> label_places(std::span<const PlotLine* const> lines, const Axis& y)
{
    constexpr double pitch = 15;
    std::vector<double> places;
    for (const PlotLine* line : lines)
        places.push_back(std::max(y.at(line->points.back().y), places.empty() ? y.to : places.back() + pitch));
    double limit = std::max(y.from, y.to + pitch * double(lines.size() - 1));
    for (std::size_t k = places.size(); k-- > 0; limit = places[k] - pitch) places[k] = std::min(places[k], limit);
    return places;
}

std::string label_text(const PlotLine& line, const PlotAxes& axes)
{
    return fmt::format("{}  {}", line.label, axes.value_text(line.points.back().y));
}

void draw_line(Svg& svg, const PlotLine& line, double label_y, bool leader, const Axis& x, const Axis& y,
               const PlotAxes& axes)
{
    const bool main = line.weight == PlotLine::Weight::main;
    const std::string_view colour = plot_colour(line.style);
    const std::string_view marker = markers[line.style % std::size(markers)], fill = main ? colour : "#ffffff";
    const std::string_view dash = main ? "none" : dashes[line.style % std::size(dashes)];
    const double stroke = main ? 2.6 : line.weight == PlotLine::Weight::peer ? 1.5 : 1;
    const auto mark = [&](double at_x, double at_y) {
        svg.print("<path fill=\"{}\" transform=\"translate({:.1f} {:.1f})\" d=\"{}\"/>\n", fill, at_x, at_y, marker);
    };
    svg.print("<g stroke=\"{}\" fill=\"none\"><path stroke-width=\"{}\" stroke-dasharray=\"{}\" d=\"", colour, stroke,
              dash);
    for (const PlotLine::Point& p : line.points)
        svg.print("{}{:.1f} {:.1f}", &p == line.points.data() ? 'M' : 'L', x.at(p.x), y.at(p.y));
    svg.print("\"/>\n");
    for (const PlotLine::Point& p : line.points) mark(x.at(p.x), y.at(p.y));
    const PlotLine::Point& last = line.points.back();
    const double label_x = right + label_gap;
    if (leader)
        svg.print("<path stroke-width=\"0.6\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>\n", x.at(last.x) + 6, y.at(last.y),
                  label_x - 16, label_y);
    mark(label_x - 9, label_y);
    svg.print("</g>\n");
    svg.text(label_x, label_y + 4, Anchor::start, main ? "main" : "value", label_text(line, axes));
}

void draw_panel(Svg& svg, const PlotPanel& panel, double top, const PlotAxes& axes)
{
    svg.text(20, top + 24, Anchor::start, "heading", panel.title);
    Axis x{.from = left, .to = right, .names = axes.x_names}, y{.from = top + plot_bottom, .to = top + plot_top};
    std::vector<const PlotLine*> lines;
    for (const PlotLine& line : panel.lines) {
        if (line.points.empty()) continue;
        lines.push_back(&line);
        for (const PlotLine::Point& p : line.points) x.add(p.x), y.add(p.y);
    }
    if (lines.empty()) return;
    x.high = std::max(x.high, x.low + 1), y.high = std::max(y.high, y.low + 1);
    draw_axes(svg, x, y, axes);
    std::ranges::stable_sort(lines, std::greater(), [](const PlotLine* line) { return line->points.back().y; });
    const std::vector<double> places = label_places(lines, y);
    const auto end_x = [&](const PlotLine* line) { return x.at(line->points.back().x); };
    constexpr double near = 20;
    double last = left;
    for (const PlotLine* line : lines) last = std::max(last, end_x(line));
    for (std::size_t k = 0; k < lines.size(); ++k)
        draw_line(svg, *lines[k], places[k], end_x(lines[k]) > last - near, x, y, axes);
}

/// The width with all labels, for a font as wide as DejaVu Sans in bold.
double width_of(std::span<const PlotPanel> panels, const PlotAxes& axes)
{
    std::size_t longest = 0;
    for (const PlotPanel& panel : panels)
        for (const PlotLine& line : panel.lines)
            if (!line.points.empty()) longest = std::max(longest, label_text(line, axes).size());
    return std::max(least_width, right + label_gap + 8.4 * double(longest));
}

} // namespace

void draw_line_plot(OutputFile& file, std::span<const PlotPanel> panels, const PlotAxes& axes)
{
    const double height = panel_height * double(panels.size());
    Svg svg(file);
    svg.begin_file(width_of(panels, axes), height,
                   ".main{font-weight:bold}.main,.value{paint-order:stroke;stroke:#ffffff;stroke-width:3px}");
    for (std::size_t k = 0; k < panels.size(); ++k) draw_panel(svg, panels[k], panel_height * double(k), axes);
    svg.end();
}

} // namespace oncollide::tools
