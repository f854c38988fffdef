#pragma once
#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

/// True if pairs of meshes are refined with OBB trees, false: with sphere-trees.
inline bool wants_obbs(const Settings& s)
{
    if (s.bounding_volume != BoundingVolume::automatic) return s.bounding_volume == BoundingVolume::obb;
    return exact_level(s) == ExactLevel::predicates || (!s.depth && !makes_spheres_on_gpu(s.backend));
}

/// True if results distinguish touching from crossing.
inline bool wants_kinds(const Settings& s)
{
    return s.contact_kinds || s.ignore_touching;
}

/// True if cooked meshes are read where pairs come near them. Solid bodies, kinds of contact, FCL and sphere-trees need
/// all of a mesh.
inline bool reads_on_demand(const Settings& s)
{
    return s.mode == Mode::surface && !wants_kinds(s) && exact_level(s) != ExactLevel::fcl && wants_obbs(s);
}

/// True if the exact level is on and not skipped.
inline bool exact_runs(const Settings& s)
{
    return exact_level(s) != ExactLevel::off && !s.skip.contains(StageId::exact);
}

/// False if the paper's occlusion queries, which miss collisions, can decide a pair.
inline bool certified(const Settings& s)
{
    return s.backend != BackendKind::gl_query ||
           (exact_level(s) == ExactLevel::predicates && exact_runs(s) && wants_obbs(s));
}

} // namespace oncollide
