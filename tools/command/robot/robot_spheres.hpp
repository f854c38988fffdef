#pragma once
#include <optional>
#include <string>
#include <vector>

namespace oncollide::tools {

/// 'oncollide spheres' for a robot: judges a model of spheres, or makes one.
struct RobotSpheresOptions {
    std::string urdf, judge, yaml, out, csv, json, levels, html;
    std::vector<std::string> packages;
    std::optional<double> max_error;
    std::optional<int> count;
    int threads = 1;
    bool quiet = false;
};

/// Returns the exit code: 0 the model covers every link; 1 it does not.
int robot_spheres(const RobotSpheresOptions& options);

} // namespace oncollide::tools
