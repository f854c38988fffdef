#include <algorithm>

#include <oncollide/base/threads/parallel.hpp>

#include "clash/parts/part_list.hpp"

namespace oncollide::tools {

double precision_of(const PartList& parts)
{
    const auto largest = [](const Aabb& box) {
        return std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
    };
    const double far = largest(parts.bounds);
    // Elements of a building are placed in double, wherever the site lies.
    if (!std::ranges::all_of(parts.parts, [](const Part& part) { return !part.details.part_class.empty(); }))
        return 0x1p-19 * far;
    double size = 0;
    for (const auto& geometry : parts.meshes)
        if (geometry) size = std::max(size, largest(std::get<Mesh>(geometry->data).bounds));
    return std::max(0x1p-19 * size, 0x1p-45 * far);
}

void mend_parts(PartList& parts, double distance, int threads)
{
    parts.mending.resize(parts.meshes.size());
    parallel_chunks(parts.meshes.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!parts.meshes[i]) continue;
            MendedMesh result = mended(std::get<Mesh>(parts.meshes[i]->data), distance);
            parts.mending[i] = result.mending;
            if (result.mending.changed())
                parts.meshes[i] = std::make_shared<Geometry>(Geometry{parts.meshes[i]->name, std::move(result.mesh)});
        }
    });
}

} // namespace oncollide::tools
