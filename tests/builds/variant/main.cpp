// A user of a library that was built without the part OFF: that part refuses with an Error that names its option, the
// other parts work, and meshes collide as always.
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include <oncollide/base/executor.hpp>
#include <oncollide/oncollide.hpp>
#include <oncollide/samples/generators.hpp>

namespace {

using namespace oncollide;

struct Part {
    std::string name;
    std::function<void()> use;
    bool always = true; ///< in every build that does not leave it out; others need packages
};

const std::vector<Part> parts = {
    {"GL", [] { World({.backend = BackendKind::gl_compute}); }},
    {"FCL", [] { World({.exact = ExactLevel::fcl}); }},
    {"OCTOMAP", [] { make_octree(make_building_map(1, 0.5, 1)); }},
    {"OPENMP", [] { openmp_executor(); }, false},
    {"XML", [] { load_mesh("none.3mf"); }, false},
};

/// Why the part does not work; empty if it does.
std::string fault_of(const Part& part)
{
    try {
        part.use();
        return {};
    } catch (const Error& error) {
        return error.what();
    }
}

bool parts_are_right(const std::string& off)
{
    for (const Part& part : parts) {
        const std::string fault = fault_of(part);
        // A part may lack a device or a file; only the one that was left out may say that it was.
        const bool left_out = fault.find("ONCOLLIDE_" + part.name) != fault.npos;
        if (part.name == off ? left_out : !left_out || !part.always) continue;
        std::printf("without %s, %s says: '%s'\n", off.c_str(), part.name.c_str(), fault.c_str());
        return false;
    }
    return true;
}

Verdict boxes_at(double x, GeometryData other)
{
    World world({.exact = ExactLevel::predicates});
    const ModelId box = world.models().add(make_box_mesh({1, 1, 1}));
    const ModelId second = world.models().add(std::make_shared<const Geometry>(Geometry{{}, std::move(other), {}}));
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation().x() = x;
    world.bodies().add({.model = box});
    world.bodies().add({.model = second, .pose = pose});
    const FrameView frame = world.step();
    return frame.pairs.empty() ? Verdict::separate : frame.pairs[0].verdict;
}

} // namespace

int main(int count, char** arguments)
{
    const OccupancyMap map = make_occupancy_map("map", 1, std::vector<MapCell>{{-1, -1, -1, 1}, {0, 0, 0, 1}});
    for (const GeometryData& other : {GeometryData(make_box_mesh({1, 1, 1})), GeometryData(map)})
        if (boxes_at(1.5, other) != Verdict::colliding || boxes_at(3.5, other) != Verdict::separate) {
            std::printf("wrong verdicts\n");
            return 1;
        }
    return parts_are_right(count > 1 ? arguments[1] : "nothing") ? 0 : 1;
}
