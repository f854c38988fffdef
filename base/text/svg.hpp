#pragma once
#include <string>
#include <string_view>

#include <oncollide/base/text_sink.hpp>

namespace oncollide {

/// `text` for XML and HTML, between tags or in a quoted attribute, on one line. Control characters, which XML cannot
/// hold, and bytes that are not UTF-8 are written as printable() writes them.
std::string xml_escaped(std::string_view text);

/// Okabe and Ito's palette, repeated: its colours differ for every kind of colour vision.
std::string_view plot_colour(std::size_t number);

/// Writes a drawing as SVG. Units are pixels, y points down; the caller ends the drawing.
class Svg {
public:
    enum class Anchor { start, middle, end };

    explicit Svg(TextSink& out) : out_(out) {}
    /// An SVG file: white, with styles for the classes title, heading, tick, label, grid and axis.
    /// @param styles  further rules of the style sheet
    void begin_file(double width, double height, std::string_view styles = {});
    /// A drawing within an HTML page, which has the styles.
    void begin_inline(double width, double height, std::string_view title);
    void end() { out_.write("</svg>\n"); }

    /// @param style  classes of the style sheet, here and below
    void text(double x, double y, Anchor anchor, std::string_view style, std::string_view words);
    /// Text that runs upwards, centred at (x, y).
    void vertical_text(double x, double y, std::string_view style, std::string_view words);
    void line(double x1, double y1, double x2, double y2, std::string_view style);
    void rectangle(double x, double y, double width, double height, std::string_view style);
    void filled(double x, double y, double width, double height, std::string_view colour, double opacity = 1);
    template <class... Args>
    void print(fmt::format_string<Args...> format, Args&&... args)
    {
        out_.print(format, std::forward<Args>(args)...);
    }

private:
    TextSink& out_;
};

/// The step of an axis with about `ticks` ticks up to `top`: 1, 2 or 5 times a power of ten.
double axis_step(double top, int ticks);

} // namespace oncollide
