#pragma once
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/files/output_file.hpp>

namespace oncollide::tools {

/// A contender's times in a panel.
struct PlotLine {
    enum class Weight { main, peer, baseline } weight = Weight::peer;
    std::string label;
    struct Point {
        double x, y;
    };
    std::vector<Point> points; ///< x ascending
    std::size_t style = 0;     ///< equal for a contender in all panels
};

struct PlotPanel {
    std::string title;
    std::vector<PlotLine> lines;
};

/// Properties of all panels.
struct PlotAxes {
    std::string x_label, y_label;
    std::string (*value_text)(double y);   ///< formats a line's last value, with its unit, for its label
    std::vector<std::string> x_names = {}; ///< not empty: x is 0, 1, ..., with these names; else logarithmic
    std::string x_least_name = {};         ///< replaces the number at the left end, for points that have no logarithm
};

/// Draws panels one below the other; y is logarithmic. Lines differ in colour, dash and marker. Their labels are beside
/// the panel, never on the data; a thin line leads from a label to the end of its line if nothing is in between.
void draw_line_plot(OutputFile& file, std::span<const PlotPanel> panels, const PlotAxes& axes);

} // namespace oncollide::tools
