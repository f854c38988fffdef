#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/text/svg.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace oncollide {

std::string xml_escaped(std::string_view text)
{
    std::string result;
    for (const char c : printable(text)) {
        switch (c) {
        case '<':
            result += "&lt;";
            break;
        case '>':
            result += "&gt;";
            break;
        case '&':
            result += "&amp;";
            break;
        case '"':
            result += "&quot;";
            break;
        default:
            result += c;
        }
    }
    return result;
}

std::string_view plot_colour(std::size_t number)
{
    constexpr std::string_view colours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                            "#e69f00", "#56b4e9", "#000000"};
    return colours[number % std::size(colours)];
}

void Svg::begin_file(double width, double height, std::string_view styles)
{
    print("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
          "{1:.0f}\">\n<style>text{{font-family:'DejaVu Sans',Verdana,Helvetica,Arial,sans-serif;font-size:12px;"
          "fill:#222}}.title{{font-size:17px;font-weight:bold}}.heading{{font-size:15px;font-weight:bold}}"
          ".tick{{font-size:11px;fill:#555}}.label{{fill:#333}}.grid{{stroke:#e2e2e2}}.axis{{stroke:#666}}{2}"
          "</style>\n",
          width, height, styles);
    filled(0, 0, width, height, "#ffffff");
}

void Svg::begin_inline(double width, double height, std::string_view title)
{
    print("<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"{}\" width=\"{:.0f}\" "
          "height=\"{:.0f}\" viewBox=\"0 0 {:.0f} {:.0f}\">\n",
          xml_escaped(title), width, height, width, height);
}

void Svg::text(double x, double y, Anchor anchor, std::string_view style, std::string_view words)
{
    constexpr std::string_view names[] = {"start", "middle", "end"};
    print("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" class=\"{}\">{}</text>\n", x, y, names[int(anchor)],
          style, xml_escaped(words));
}

void Svg::vertical_text(double x, double y, std::string_view style, std::string_view words)
{
    print("<text transform=\"translate({} {:.1f}) rotate(-90)\" text-anchor=\"middle\" class=\"{}\">{}</text>\n", x, y,
          style, xml_escaped(words));
}

void Svg::line(double x1, double y1, double x2, double y2, std::string_view style)
{
    print("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>\n", x1, y1, x2, y2, style);
}

void Svg::rectangle(double x, double y, double width, double height, std::string_view style)
{
    print("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" class=\"{}\"/>\n", x, y, width, height,
          style);
}

void Svg::filled(double x, double y, double width, double height, std::string_view colour, double opacity)
{
    print("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\" fill-opacity=\"{}\"/>\n", x,
          y, std::max(width, 0.0), std::max(height, 0.0), colour, opacity);
}

double axis_step(double top, int ticks)
{
    const double power = std::pow(10, std::floor(std::log10(top / ticks)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power * ticks >= top) return factor * power;
    return 10 * power;
}

} // namespace oncollide
