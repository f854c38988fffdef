#pragma once
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/output_file.hpp>

namespace oncollide::tools {

/// One contender's times in one panel.
struct PlotLine {
    enum class Weight { main, peer, baseline } weight = Weight::peer;
    std::string label;
    struct Point {
        double x, y;
    };
    std::vector<Point> points; ///< x ascending
    std::size_t style = 0;     ///< the same contender has the same one in every panel
};

struct PlotPanel {
    std::string title;
    std::vector<PlotLine> lines;
};

/// What all panels have in common.
struct PlotAxes {
    std::string x_label, y_label;
    std::string (*value_text)(double y); ///< a line's last value, with its unit, beside its label
    std::vector<std::string> x_names =
        {};                        ///< when there are any, x is 0, 1, ...: these, evenly spaced; else logarithmic
    std::string x_least_name = {}; ///< in place of the number at the left end, for points that have no logarithm
};

/// One panel below the other; y is logarithmic. Lines differ in colour, dash and marker, and are labelled at their
/// ends.
void draw_line_plot(OutputFile& file, std::span<const PlotPanel> panels, const PlotAxes& axes);

} // namespace oncollide::tools
