// SegmentQuery: the first point of a segment in a model.
#include <algorithm>

#include <oncollide/narrowphase/rays/segment_query.hpp>
#include <oncollide/narrowphase/shapes/outward_normal.hpp>

namespace oncollide {

namespace {

/// An upper bound on the rounding of the fractions at which the walk enters boxes.
double slack_of(const Segment& segment, const auto& tree)
{
    const double largest = std::max(segment.from.cwiseAbs().maxCoeff(), segment.to.cwiseAbs().maxCoeff()) +
                           tree.centre().cwiseAbs().maxCoeff() + tree.radius();
    return 0x1p-40 + 0x1p-44 * largest / (segment.to - segment.from).norm();
}

} // namespace

void SegmentQuery::add(const std::optional<SegmentEntry>& entry, const BodyPart& part, std::uint32_t number,
                       double& reach)
{
    if (!entry || entry->lower > reach) return;
    candidates_.push_back({*entry, part, number});
    reach = std::min(reach, entry->upper);
}

/// The smallest part among the candidates that may be the first, with bounds that enclose the first fraction.
std::optional<SegmentQuery::Candidate> SegmentQuery::nearest_candidate(double reach) const
{
    std::optional<Candidate> nearest;
    for (const Candidate& next : candidates_) {
        if (next.entry.lower > reach) continue;
        if (!nearest) nearest = next;
        const SegmentEntry entry{std::min(nearest->entry.lower, next.entry.lower),
                                 std::min(nearest->entry.upper, next.entry.upper)};
        if (next.part < nearest->part) nearest = next;
        nearest->entry = entry;
    }
    return nearest;
}

/// @param tree   the tree of the primitives
/// @param entry  entry(primitive, across) returns the entry into a primitive; across: the segment crosses its inside
template <class Tree, class Entry>
std::optional<SegmentQuery::Candidate> SegmentQuery::nearest(auto& walk, auto& walked, const Tree& tree,
                                                             const Segment& segment, double reach, Entry entry)
{
    candidates_.clear();
    const double slack = slack_of(segment, tree);
    const auto take = [&](const auto& primitive, bool across = false) {
        if constexpr (std::same_as<Tree, ObbTree>)
            add(entry(primitive, across), tree.source(primitive), primitive, reach);
        else
            add(entry(primitive, across), primitive, 0, reach);
        return reach + slack;
    };
    walk.walk(walked, segment, take, reach + slack);
    return nearest_candidate(reach);
}

/// The first point on a mesh, or on the surface of a box or a hull.
std::optional<SegmentHit> SegmentQuery::first_on_surface(Model& model, const Segment& segment, double reach)
{
    ObbTree* const tree = model.obb_tree();
    const auto corners = [&](std::uint32_t triangle) -> TrianglePoints {
        return tree ? tree->corners(triangle) : corners_of(*model.surface_mesh(), triangle);
    };
    const auto entry = [&](std::uint32_t triangle, bool across = false) -> std::optional<SegmentEntry> {
        if (across) return entry_across(segment, corners(triangle));
        return entry_of(segment, corners(triangle));
    };
    std::optional<Candidate> found;
    if (RayTree* const rays = RayWalk::covers(segment) ? model.ray_tree() : nullptr) {
        found = nearest(rays_, *rays, *tree, segment, reach, entry);
    } else if (tree) {
        found = nearest(meshes_, *tree, *tree, segment, reach, entry);
    } else {
        ONCOLLIDE_ASSERT(model.kind() == Kind::polytope);
        candidates_.clear();
        for (std::uint32_t t = 0; t < model.surface_mesh()->triangles.size(); ++t) add(entry(t), t, t, reach);
        found = nearest_candidate(reach);
    }
    if (!found) return {};
    return SegmentHit{found->entry, model.shape() ? BodyPart() : found->part,
                      normal_facing(segment, corners(found->number))};
}

std::optional<SegmentHit> SegmentQuery::first(Model& model, const Segment& segment, bool solid, double reach)
{
    const auto zero = Eigen::Vector3d::Zero();
    switch (model.kind()) {
    case Kind::mesh:
    case Kind::polytope:
        if (begins_inside(model, segment, solid)) return SegmentHit{{0, 0}, {}, zero};
        return first_on_surface(model, segment, reach);
    case Kind::terrain: {
        TerrainTree& tree = model.heights();
        const auto entry = [&](std::uint32_t triangle, bool across) -> std::optional<SegmentEntry> {
            if (across) return entry_across(segment, tree.points(triangle));
            return entry_of(segment, tree.points(triangle));
        };
        const auto found = nearest(terrains_, tree, tree, segment, reach, entry);
        if (!found) return {};
        return SegmentHit{found->entry, found->part, normal_facing(segment, tree.points(found->part.triangle))};
    }
    case Kind::map: {
        const auto box = [&](const MapCell& cell) { return MapAccess::box(*model.map(), cell); };
        const MapTree& tree = model.cells();
        const auto found = nearest(maps_, tree, tree, segment, reach,
                                   [&](const MapCell& cell, bool) { return entry_of(segment, box(cell)); });
        if (!found) return {};
        return SegmentHit{found->entry, found->part, normal_facing(segment, box(found->part.cell))};
    }
    case Kind::round: {
        const std::optional<SegmentEntry> entry = entry_of(segment, model.convex());
        if (!entry || entry->lower > reach) return {};
        if (entry->upper == 0) return SegmentHit{*entry, {}, zero};
        const double at = entry->certain ? 0.5 * (entry->lower + entry->upper) : entry->lower;
        return SegmentHit{*entry, {}, outward_normal(model.convex(), (1 - at) * segment.from + at * segment.to)};
    }
    case Kind::half_space: {
        const std::optional<SegmentEntry> entry = entry_in_half_space(segment);
        if (!entry || entry->lower > reach) return {};
        return SegmentHit{*entry, {}, (entry->upper > 0 ? 1 : 0) * Eigen::Vector3d::UnitZ()};
    }
    }
    __builtin_unreachable();
}

} // namespace oncollide
