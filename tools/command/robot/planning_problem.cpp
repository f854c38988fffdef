#include "robot/planning_problem.hpp"

#include <algorithm>

#include <oncollide/base/error.hpp>

namespace oncollide::tools {

namespace fs = std::filesystem;

std::vector<PlanningProblem> load_problems(const fs::path& folder, std::size_t most)
{
    std::error_code error;
    std::vector<fs::path> scenes;
    for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
        if (at->path().filename().string().starts_with("scene") && at->path().extension() == ".yaml")
            scenes.push_back(at->path());
    if (error || scenes.empty())
        throw Error(ErrorKind::no_input,
                    folder.string() +
                        ": holds no scene*.yaml of MotionBenchMaker; unpack the archive of problems first");
    std::ranges::sort(scenes);
    std::vector<PlanningProblem> problems;
    std::map<std::string, std::size_t> counts;
    for (const fs::path& scene : scenes) {
        if (most && ++counts[scene.parent_path().string()] > most) continue;
        const std::string number = scene.filename().string().substr(5);
        PlanningProblem problem = read_problem(scene, scene.parent_path() / ("request" + number));
        problem.set = scene.parent_path().filename().string(), problem.name = number.substr(0, number.find('.'));
        problems.push_back(std::move(problem));
    }
    return problems;
}

} // namespace oncollide::tools
