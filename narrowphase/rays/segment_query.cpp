#include <oncollide/narrowphase/rays/segment_query.hpp>

#include <oncollide/narrowphase/rays/segment_tests.hpp>

namespace oncollide {

/// @param meets  tests a primitive of which the walk is not certain
template <class Tree, class Meets>
bool SegmentQuery::any(auto& walk, Tree& tree, const Segment& segment, Meets meets)
{
    bool met = false;
    walk.walk(tree, segment, [&](const auto& primitive, bool certain = false) {
        met = certain || meets(primitive);
        return met ? -1.0 : 1.0;
    });
    return met;
}

Finding SegmentQuery::decide(Model& model, const Segment& segment, bool solid)
{
    if (meets(model, segment)) return {Verdict::colliding, ContactKind::unknown, 0};
    if (begins_inside(model, segment, solid)) return {Verdict::colliding, ContactKind::enclosed, 0};
    return {Verdict::separate, ContactKind::unknown, 0};
}

/// True if the segment begins inside or on the surface of a model whose surface has an inside.
bool SegmentQuery::begins_inside(Model& model, const Segment& segment, bool solid)
{
    if (model.kind() != Kind::polytope && !(solid && model.closed())) return false;
    ObbTree* const tree = model.obb_tree();
    if (tree && (segment.from - tree->centre()).cwiseAbs().maxCoeff() > tree->radius() * (1 + 0x1p-40)) return false;
    const RelativePose same(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
    return locator_.place(segment.from, *model.surface_mesh(), tree, same) != PointLocation::outside;
}

bool SegmentQuery::meets_surface(Model& model, ObbTree& tree, const Segment& segment)
{
    const auto meets = [&](std::uint32_t triangle) { return segment_meets(segment, tree.corners(triangle)); };
    RayTree* const rays = RayWalk::covers(segment) ? model.ray_tree() : nullptr;
    return rays ? any(rays_, *rays, segment, meets) : any(meshes_, tree, segment, meets);
}

bool SegmentQuery::meets(Model& model, const Segment& segment)
{
    switch (model.kind()) {
    case Kind::mesh:
    case Kind::polytope:
        if (ObbTree* const tree = model.obb_tree()) return meets_surface(model, *tree, segment);
        ONCOLLIDE_ASSERT(model.kind() == Kind::polytope);
        return std::ranges::any_of(model.surface_mesh()->triangles, [&](const Triangle& t) {
            const auto& vertices = model.surface_mesh()->vertices;
            return segment_meets(segment, TrianglePoints{vertices[t[0]], vertices[t[1]], vertices[t[2]]});
        });
    case Kind::terrain: {
        const TerrainTree& tree = model.heights();
        return any(terrains_, tree, segment,
                   [&](std::uint32_t triangle) { return segment_meets(segment, tree.points(triangle)); });
    }
    case Kind::map: {
        return any(maps_, model.cells(), segment,
                   [&](const MapCell& cell) { return segment_meets(segment, MapAccess::box(*model.map(), cell)); });
    }
    case Kind::round:
    case Kind::half_space:
        break;
    }
    ONCOLLIDE_ASSERT(false);
    return false;
}

} // namespace oncollide
