#include <oncollide/base/threads/parallel.hpp>

#include "clash/parts/part_list.hpp"

namespace oncollide::tools {

void mend_parts(PartList& parts, double distance, int threads)
{
    parts.mending.resize(parts.meshes.size());
    parallel_chunks(parts.meshes.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!parts.meshes[i]) continue;
            MendedMesh result = mended(std::get<Mesh>(parts.meshes[i]->data), distance);
            parts.mending[i] = result.mending;
            if (result.mending.changed())
                parts.meshes[i] = std::make_shared<Geometry>(Geometry{parts.meshes[i]->name, std::move(result.mesh), {}});
        }
    });
}

} // namespace oncollide::tools
