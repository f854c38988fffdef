#include "bench/line_plot.hpp"
#include "study/markup.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace oncollide::tools {
namespace {

constexpr double width = 960, left = 76, right = 690, label_gap = 28;
constexpr double panel_height = 480, plot_top = 46, plot_bottom = 420;
// Okabe and Ito's palette, distinguishable with any colour vision.
constexpr std::string_view colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"};
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

void segment(OutputFile& file, double x1, double y1, double x2, double y2, std::string_view style)
{
    file.print("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>\n", x1, y1, x2, y2, style);
}

/// A logarithmic axis over whole decades, or an axis of named positions.
struct Axis {
    double from = 0, to = 0;                 ///< pixels
    std::span<const std::string> names = {}; ///< names of 0, 1, 2, ...
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

void draw_axes(OutputFile& file, const Axis& x, const Axis& y, const PlotAxes& axes)
{
    for (double tick = x.low; tick <= x.high; ++tick) {
        segment(file, x.at_tick(tick), y.from, x.at_tick(tick), y.to, tick == x.low ? "axis" : "grid");
        const bool named = !x.names.empty() && tick < double(x.names.size());
        if (tick == x.low && !axes.x_least_name.empty())
            svg_text(file, x.at_tick(tick), y.from + 17, "middle", "tick", axes.x_least_name);
        else if (x.names.empty() || named)
            svg_text(file, x.at_tick(tick), y.from + 17, "middle", "tick",
                     named ? x.names[std::size_t(tick)] : tick_text(std::pow(10, tick)));
    }
    for (double decade = y.low; decade <= y.high; ++decade) {
        const double value = std::pow(10, decade);
        segment(file, x.from, y.at(value), x.to, y.at(value), decade == y.low ? "axis" : "grid");
        svg_text(file, x.from - 8, y.at(value) + 4, "end", "tick", fmt::format("{:g}", value));
    }
    svg_text(file, 0.5 * (x.from + x.to), y.from + 36, "middle", "label", axes.x_label);
    file.print(
        "<text transform=\"translate(18 {:.1f}) rotate(-90)\" text-anchor=\"middle\" class=\"label\">{}</text>\n",
        0.5 * (y.from + y.to), escaped(axes.y_label));
}

/// Heights of the labels of lines that end at the same x: at the lines' ends if there is room, otherwise moved apart.
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

void draw_line(OutputFile& file, const PlotLine& line, double label_y, const Axis& x, const Axis& y,
               const PlotAxes& axes)
{
    const bool main = line.weight == PlotLine::Weight::main;
    const std::string_view colour = colours[line.style % std::size(colours)];
    const std::string_view marker = markers[line.style % std::size(markers)], fill = main ? colour : "#ffffff";
    const std::string_view dash = main ? "none" : dashes[line.style % std::size(dashes)];
    const double stroke = main ? 2.6 : line.weight == PlotLine::Weight::peer ? 1.5 : 1;
    const auto mark = [&](double at_x, double at_y) {
        file.print("<path fill=\"{}\" transform=\"translate({:.1f} {:.1f})\" d=\"{}\"/>\n", fill, at_x, at_y, marker);
    };
    file.print("<g stroke=\"{}\" fill=\"none\"><path stroke-width=\"{}\" stroke-dasharray=\"{}\" d=\"", colour, stroke,
               dash);
    for (const PlotLine::Point& p : line.points)
        file.print("{}{:.1f} {:.1f}", &p == line.points.data() ? 'M' : 'L', x.at(p.x), y.at(p.y));
    file.print("\"/>\n");
    for (const PlotLine::Point& p : line.points) mark(x.at(p.x), y.at(p.y));
    const PlotLine::Point& last = line.points.back();
    const double label_x = x.at(last.x) + label_gap;
    file.print("<path stroke-width=\"0.6\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>\n", x.at(last.x) + 6, y.at(last.y),
               label_x - 16, label_y);
    mark(label_x - 9, label_y);
    file.print("</g>\n");
    svg_text(file, label_x, label_y + 4, "start", main ? "main" : "value",
             fmt::format("{}  {}", line.label, axes.value_text(last.y)));
}

void draw_panel(OutputFile& file, const PlotPanel& panel, double top, const PlotAxes& axes)
{
    svg_text(file, 20, top + 24, "start", "heading", panel.title);
    Axis x{.from = left, .to = right, .names = axes.x_names}, y{.from = top + plot_bottom, .to = top + plot_top};
    std::vector<const PlotLine*> lines;
    for (const PlotLine& line : panel.lines) {
        if (line.points.empty()) continue;
        lines.push_back(&line);
        for (const PlotLine::Point& p : line.points) x.add(p.x), y.add(p.y);
    }
    if (lines.empty()) return;
    x.high = std::max(x.high, x.low + 1), y.high = std::max(y.high, y.low + 1);
    draw_axes(file, x, y, axes);
    // Lines with ends near each other share the space for labels, the slowest on top.
    constexpr double near = 60;
    const auto end_x = [&](const PlotLine* line) { return x.at(line->points.back().x); };
    std::ranges::stable_sort(lines, {}, end_x);
    for (std::size_t begin = 0, end = 0; begin < lines.size(); begin = end) {
        while (end < lines.size() && end_x(lines[end]) < end_x(lines[begin]) + near) ++end;
        const auto group = std::span(lines).subspan(begin, end - begin);
        std::ranges::stable_sort(group, std::greater(), [](const PlotLine* line) { return line->points.back().y; });
        const std::vector<double> places = label_places(group, y);
        for (std::size_t k = 0; k < group.size(); ++k) draw_line(file, *group[k], places[k], x, y, axes);
    }
}

} // namespace

void draw_line_plot(OutputFile& file, std::span<const PlotPanel> panels, const PlotAxes& axes)
{
    const double height = panel_height * double(panels.size());
    file.print(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1:.0f}\" viewBox=\"0 0 {0} {1:.0f}\">\n",
        width, height);
    file.print("<style>text{{font-family:'DejaVu Sans',Verdana,Helvetica,Arial,sans-serif;font-size:12px;fill:#222}}"
               ".heading{{font-size:15px;font-weight:bold}}.main{{font-weight:bold}}"
               ".tick{{font-size:11px;fill:#555}}.label{{fill:#333}}"
               ".grid{{stroke:#e2e2e2}}.axis{{stroke:#666}}"
               ".main,.value{{paint-order:stroke;stroke:#ffffff;stroke-width:3px}}</style>\n"
               "<rect width=\"{}\" height=\"{:.0f}\" fill=\"#ffffff\"/>\n",
               width, height);
    for (std::size_t k = 0; k < panels.size(); ++k) draw_panel(file, panels[k], panel_height * double(k), axes);
    file.print("</svg>\n");
}

} // namespace oncollide::tools
