#include <oncollide/runs/deforming_models.hpp>

#include <fmt/format.h>

namespace oncollide {

ModelId add_model(Models& models, const GeometryList& geometries, std::uint32_t g)
{
    const ModelId model = models.add(geometries.share(g));
    if (geometries.deforms(g)) renew_model(models, model, geometries, g);
    return model;
}

void renew_model(Models& models, ModelId model, const GeometryList& geometries, std::uint32_t g)
{
    if (geometries.deforms(g))
        models.set_vertices(model, std::get<Mesh>(geometries[g].data).vertices);
    else
        models.replace(model, geometries.share(g));
}

void check_rigid(const GeometryList& geometries)
{
    if (geometries.deforming().empty()) return;
    throw Error(ErrorKind::usage,
                fmt::format("geometry '{}' deforms: contacts on the way from frame to frame (--continuous) are found "
                            "for rigid geometries only; run without it, and with more frames (--pace 0.1) where the "
                            "motion between two frames matters",
                            geometries[geometries.deforming().front()].name));
}

} // namespace oncollide
