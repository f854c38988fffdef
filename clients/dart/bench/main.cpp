// oncollide-dart-bench: scenes of DART with the detectors FCL, Bullet, ODE and oncollide in one run.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenes.hpp"

using namespace dart::collision::oncollide_client::bench;

namespace {

struct Row {
    std::string scene, variant, detector;
    Measures measures;
};

void print(const Row& row)
{
    fmt::print("{:9} {:18} {:10}", row.scene, row.variant, row.detector);
    for (const auto& [name, value] : row.measures) fmt::print("  {} {:.4g}", name, value);
    fmt::print("\n");
    std::fflush(stdout);
}

void write(const std::string& path, const std::vector<Row>& rows)
{
    std::ofstream file(path);
    if (path.ends_with(".json")) {
        nlohmann::json all = nlohmann::json::array();
        for (const Row& row : rows) {
            nlohmann::json one{{"scene", row.scene}, {"variant", row.variant}, {"detector", row.detector}};
            for (const auto& [name, value] : row.measures) one[name] = value;
            all.push_back(one);
        }
        file << all.dump(1) << "\n";
    } else {
        file << "scene,variant,detector,measure,value\n";
        for (const Row& row : rows)
            for (const auto& [name, value] : row.measures)
                file << fmt::format("{},\"{}\",{},\"{}\",{:.6g}\n", row.scene, row.variant, row.detector, name, value);
    }
    if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

std::string file_name(const SceneRun& scene)
{
    std::string name = "dart-" + scene.scene + "-" + scene.variant;
    std::erase(name, ','), std::erase(name, '.');
    std::replace(name.begin(), name.end(), ' ', '-');
    return name + ".png";
}

int run(int count, char** arguments)
{
    CLI::App app{"Runs scenes in DART with each detector, in one process, 1 ms steps. Times are processor times."};
    std::vector<std::string> only_scenes, only_detectors, files;
    std::string pictures, data = std::getenv("ONCOLLIDE_DATA") ? std::getenv("ONCOLLIDE_DATA") : "../shared/data";
    Limits limits;
    app.add_option("--scene", only_scenes, "stack, slide, enclosed, pile, overlap, 'nut M16' (default: all)");
    app.add_option("--detector", only_detectors, "fcl, bullet, ode, oncollide (default: all)")
        ->check(CLI::IsMember(detectors));
    app.add_option("--budget", limits.budget, "seconds of processor time for one run")->capture_default_str();
    app.add_option("--scale", limits.scale, "factor of all simulated times")->capture_default_str();
    app.add_option("--data", data, "folder with contacts/ and meshes/, for the nut and the cows")
        ->capture_default_str();
    app.add_option("--out", files, "files to write: .csv or .json");
    app.add_option("--pictures", pictures, "folder for a PNG of each scene's end, the detectors from left to right")
        ->check(CLI::ExistingDirectory);
    CLI11_PARSE(app, count, arguments);

    std::vector<Row> rows;
    for (const SceneRun& scene : all_scenes(data)) {
        const auto wanted = [](const auto& list, const std::string& name) {
            return list.empty() || std::find(list.begin(), list.end(), name) != list.end();
        };
        if (!wanted(only_scenes, scene.scene)) continue;
        std::vector<View> views;
        for (const std::string& detector : detectors)
            if (wanted(only_detectors, detector)) {
                rows.push_back(
                    {scene.scene, scene.variant, detector, scene.run(detector, limits, views.emplace_back())});
                print(rows.back());
            }
        if (!pictures.empty()) save_pictures(std::filesystem::path(pictures) / file_name(scene), views);
    }
    if (rows.empty())
        throw std::runtime_error("no scene of these names: " + fmt::format("{}", fmt::join(only_scenes, ", ")));
    for (const std::string& path : files) write(path, rows);
    return 0;
}

} // namespace

int main(int count, char** arguments)
{
    try {
        return run(count, arguments);
    } catch (const std::exception& error) {
        std::cerr << "oncollide-dart-bench: " << error.what() << "\n";
        return 1;
    }
}
