#include "clash/clash_view.hpp"

#include <fmt/format.h>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/runs/pipeline.hpp>

#include "view/view_page.hpp"

namespace oncollide::tools {
namespace {

Scene scene_of(const PartList& list)
{
    Scene scene;
    scene.name = "Clashes";
    std::vector<GeometryId> geometries(list.meshes.size());
    for (std::size_t i = 0; i < list.meshes.size(); ++i)
        if (list.meshes[i])
            geometries[i] = scene.add(fmt::format("{} #{}", list.meshes[i]->name, i), list.meshes[i]->data);
    for (const Part& part : list.parts) {
        const auto [layer, mask] = layers_of(list, part);
        scene.add_body({.name = part.name,
                        .geometry = geometries[part.mesh],
                        .pose = part.pose,
                        .layer = layer,
                        .mask = mask,
                        .group = part.group});
    }
    return scene;
}

} // namespace

std::string write_clash_view(const std::string& file, const ClashReport& report, std::size_t most_bytes)
{
    const Scene scene = scene_of(report.parts);
    Pipeline pipeline(scene, settings_of(report.settings));
    ViewPage page(scene, pipeline,
                  {.file = file,
                   .most_bytes = most_bytes,
                   .frames = 1,
                   .threads = thread_count(pipeline.settings()),
                   .metres = 1e-3 * report.unit.millimetres});
    page.add(pipeline.step(scene));
    page.close();
    return page.summary();
}

} // namespace oncollide::tools
