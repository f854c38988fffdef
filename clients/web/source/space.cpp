// Queries of one thing against all bodies. The lists of many queries lie one after the other; list 1 has their offsets.
#include "call.hpp"
#include "world.hpp"

using namespace oncollide;
using namespace oncollide::web;

namespace {

Eigen::Vector3d point_at(const double* numbers, std::size_t i)
{
    return Eigen::Map<const Eigen::Vector3d>(numbers + 3 * i);
}

void put(const std::vector<std::vector<QueryHit>>& lists)
{
    std::size_t count = 0, i = 0;
    for (const auto& list : lists) count += list.size();
    ColumnWriter rows(results(), count, 4);
    double* const offsets = results(1).make(lists.size() + 1, 1);
    offsets[0] = 0;
    for (std::size_t k = 0; k < lists.size(); ++k) {
        for (const QueryHit& hit : lists[k]) {
            rows.next(i, number_of(hit.body)), rows.next(i, static_cast<double>(hit.verdict));
            rows.next(i, static_cast<double>(hit.kind)), rows.next(i, hit.bound), rows.end_row(), ++i;
        }
        offsets[k + 1] = double(i);
    }
}

/// -1: no body.
double number_or_none(BodyId body)
{
    return body ? number_of(body) : -1;
}

void put(ColumnWriter& rows, std::size_t i, const CastHit& hit)
{
    rows.next(i, number_or_none(hit.body)), rows.next(i, static_cast<double>(hit.verdict));
    rows.next(i, hit.fraction_lower), rows.next(i, hit.fraction_upper);
    rows.next(i, hit.part.cell.side ? -1 : hit.part.triangle);
    rows.next(i, hit.point), rows.next(i, hit.normal), rows.end_row();
}

void put(ColumnWriter& rows, std::size_t i, const SweepHit& hit)
{
    rows.next(i, number_or_none(hit.body)), rows.next(i, static_cast<double>(hit.verdict));
    rows.next(i, static_cast<double>(hit.kind)), rows.next(i, hit.clear_until), rows.next(i, hit.contact_by);
    rows.next(i, hit.gap), rows.next(i, hit.contact.middle()), rows.next(i, hit.normal), rows.end_row();
}

constexpr std::size_t cast_width = 11, sweep_width = 12;

} // namespace

/// Form 0: a model at `count` poses; 1: segments; 2: boxes. One: poses, first points or low corners.
ONCOLLIDE_WEB int oc_overlaps(const HeldWorld* held, int form, double model, const double* one, const double* other,
                              std::size_t count, std::uint32_t layer, std::uint32_t mask, std::uint32_t group)
{
    return call([=] {
        const CollisionFilter filter{layer, mask, group};
        const Space space = held->world.space();
        std::vector<std::vector<QueryHit>> lists(count);
        for (std::size_t i = 0; i < count; ++i)
            lists[i] = form == 0   ? space.overlaps(PlacedModel{held->model(model), pose_at(one, i)}, filter)
                       : form == 1 ? space.overlaps(Segment{point_at(one, i), point_at(other, i)}, filter)
                                   : space.overlaps(Aabb{point_at(one, i), point_at(other, i)}, filter);
        put(lists);
    });
}
/// Body, verdict, fractions, part, point, normal of the first hit of each segment; or, if `all`, of all hits of one.
ONCOLLIDE_WEB int oc_cast(const HeldWorld* held, const double* starts, const double* ends, std::size_t count, bool all,
                          std::uint32_t layer, std::uint32_t mask, std::uint32_t group)
{
    return call([=] {
        const CollisionFilter filter{layer, mask, group};
        const Space space = held->world.space();
        if (all) {
            const std::vector<CastHit> hits = space.cast_all(Segment{point_at(starts, 0), point_at(ends, 0)}, filter);
            ColumnWriter rows(results(), hits.size(), cast_width);
            for (std::size_t i = 0; i < hits.size(); ++i) put(rows, i, hits[i]);
            return;
        }
        std::vector<CastHit> hits(count);
        for (std::size_t i = 0; i < count; ++i)
            hits[i] = space.cast(Segment{point_at(starts, i), point_at(ends, i)}, filter);
        ColumnWriter rows(results(), count, cast_width);
        for (std::size_t i = 0; i < count; ++i) put(rows, i, hits[i]);
    });
}
/// Body, verdict, kind, times, gap, point, normal: the first contact of a model that moves from a pose to another; or,
/// if `all`, that with each body.
ONCOLLIDE_WEB int oc_cast_model(const HeldWorld* held, double model, const double* from, const double* to, bool all,
                                std::uint32_t layer, std::uint32_t mask, std::uint32_t group, int path,
                                double time_tolerance, double gap_tolerance, int most_steps, int stop)
{
    return call([=] {
        const MovingModel moving{held->model(model), RigidMotion(pose_at(from, 0), pose_at(to, 0), MotionPath(path))};
        const SweepOptions options{.time_tolerance = time_tolerance,
                                   .gap_tolerance = gap_tolerance,
                                   .most_steps = most_steps,
                                   .stop = static_cast<SweepStop>(stop)};
        const CollisionFilter filter{layer, mask, group};
        std::vector<SweepHit> hits;
        if (all)
            hits = held->world.space().cast_all(moving, filter, options);
        else
            hits.push_back(held->world.space().cast(moving, filter, options));
        ColumnWriter rows(results(), hits.size(), sweep_width);
        for (std::size_t i = 0; i < hits.size(); ++i) put(rows, i, hits[i]);
    });
}
/// Body, bounds, parts, nearest points of each body within `cutoff` of a model at a pose.
ONCOLLIDE_WEB int oc_distances(const HeldWorld* held, double model, const double* pose, double cutoff, double tolerance,
                               std::uint32_t layer, std::uint32_t mask, std::uint32_t group)
{
    return call([=] {
        const std::vector<BodyDistance> found = held->world.space().distances(
            {held->model(model), pose_at(pose, 0)}, {layer, mask, group}, {.tolerance = tolerance, .cutoff = cutoff});
        ColumnWriter rows(results(), found.size(), 11);
        for (std::size_t i = 0; i < found.size(); ++i) {
            const Distance& d = found[i].distance;
            rows.next(i, number_of(found[i].body)), rows.next(i, d.lower), rows.next(i, d.upper);
            rows.next(i, d.a.cell.side ? -1 : d.a.triangle), rows.next(i, d.b.cell.side ? -1 : d.b.triangle);
            rows.next(i, d.point_a), rows.next(i, d.point_b), rows.end_row();
        }
    });
}
