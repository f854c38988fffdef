#include "view/page_deforming.hpp"

#include <algorithm>

namespace oncollide::tools {

DeformingModels::DeformingModels(const Scene& scene, std::uint64_t most) : scene_(scene)
{
    for (const std::uint32_t g : scene.geometries.deforming())
        if (std::ranges::find(scene.geometry, GeometryId{g}) != scene.geometry.end()) shown_.push_back({g, {}, {}});
    for (Shown& shown : shown_)
        shown.model = make_page_model(scene, GeometryId{shown.geometry}, most / shown_.size(), shown.source);
}

const PageModel* DeformingModels::of(std::uint32_t geometry) const
{
    const auto found = std::ranges::find(shown_, geometry, &Shown::geometry);
    return found == shown_.end() ? nullptr : &found->model;
}

DeformingModels::Columns DeformingModels::columns() const
{
    Columns columns;
    for (const Shown& shown : shown_) {
        const auto& mesh = std::get<oncollide::Mesh>(scene_.geometries[shown.geometry].data);
        for (const Eigen::Vector3d& corner : {mesh.bounds.min, mesh.bounds.max})
            columns.boxes.insert(columns.boxes.end(), corner.begin(), corner.end());
        for (const std::uint32_t v : shown.source) {
            const std::array<std::uint16_t, 3> at = fraction_of(mesh.bounds, mesh.vertices[v]);
            columns.vertices.insert(columns.vertices.end(), at.begin(), at.end());
        }
    }
    return columns;
}

std::size_t DeformingModels::bytes_of_frame() const
{
    std::size_t bytes = 0;
    for (const Shown& shown : shown_) bytes += 6 * sizeof(double) + 6 * shown.source.size();
    return bytes;
}

} // namespace oncollide::tools
