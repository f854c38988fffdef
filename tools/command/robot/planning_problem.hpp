#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/model/shape.hpp>

namespace oncollide::tools {

/// A problem of MotionBenchMaker: obstacles, and the first and the last configuration of a motion.
struct PlanningProblem {
    struct Obstacle {
        std::string name;
        Shape shape;
        Eigen::Isometry3d pose;
    };
    std::string set, name; ///< folder, "0017"
    std::vector<Obstacle> obstacles;
    std::map<std::string, double> start, goal; ///< by joint; the goal has the joints that move
};

/// The problems of a folder, which has a folder for each set: scene0001.yaml and request0001.yaml, and so on. Sorted.
/// Throws Error{no_input} if there are none, Error{bad_data} naming file and line.
/// @param most  most problems of each set; 0: all
std::vector<PlanningProblem> load_problems(const std::filesystem::path& folder, std::size_t most);

/// One problem.
PlanningProblem read_problem(const std::filesystem::path& scene, const std::filesystem::path& request);

} // namespace oncollide::tools
