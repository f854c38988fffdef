#pragma once
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/output_file.hpp>

namespace oncollide::tools {

/// One contender's times in one scene.
struct PlotLine {
    enum class Weight { main, peer, baseline } weight = Weight::peer;
    std::string label;
    struct Point {
        double boxes, time;
    };
    std::vector<Point> points; ///< ascending
    std::size_t style = 0;     ///< the same contender has the same one in every panel
};

struct PlotPanel {
    std::string title;
    std::vector<PlotLine> lines;
};

/// Time against size, both logarithmic, one panel a scene. Lines differ in colour, dash and marker, and are labelled at
/// their ends.
/// @param per_box  times are nanoseconds a box, not milliseconds a frame
void draw_broad_plot(OutputFile& file, std::span<const PlotPanel> panels, bool per_box);

} // namespace oncollide::tools
