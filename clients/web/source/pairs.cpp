// Queries of two sides. A side is a body, or, with poses, a model at a pose.
#include "call.hpp"
#include "world.hpp"

using namespace oncollide;
using namespace oncollide::web;

namespace {

/// The pairs of a query, as JavaScript gives them. A side that has poses is a model.
struct GivenPairs {
    const HeldWorld* held;
    const double *a, *b;             ///< `count` ids each
    const double *poses_a, *poses_b; ///< null: bodies
    std::size_t count;

    /// Calls work(i, a, b) with the two sides of each pair.
    template <class Work>
    void each(Work work) const
    {
        for (std::size_t i = 0; i < count; ++i) {
            PlacedModel model_a, model_b;
            const auto side = [&](double id, const double* poses, PlacedModel& model) -> PairSide {
                if (!poses) return held->body(id);
                model = {held->model(id), pose_at(poses, i)};
                return model;
            };
            const PairSide first = side(a[i], poses_a, model_a), second = side(b[i], poses_b, model_b);
            work(i, first, second);
        }
    }
};

double number_of_part(const BodyPart& part)
{
    return part.cell.side ? -1 : part.triangle;
}

void put(ColumnWriter& rows, std::size_t i, const Contact& contact)
{
    rows.next(i, number_of_part(contact.a)), rows.next(i, number_of_part(contact.b));
    rows.next(i, static_cast<double>(contact.kind));
    rows.next(i, contact.ends[0]), rows.next(i, contact.ends[1]);
    rows.next(i, contact.normal_a), rows.next(i, contact.normal_b);
}

/// Offsets of the lists of each of many queries.
void put_offsets(Results& to, std::span<const std::size_t> offsets)
{
    double* const at = to.make(offsets.size(), 1);
    for (std::size_t i = 0; i < offsets.size(); ++i) at[i] = double(offsets[i]);
}

/// List 0: regions; 1: points; 2: offsets of the regions of each pair; 3: whether each is complete.
void put(const ManifoldLists& found)
{
    ColumnWriter rows(results(), found.regions.size(), 13);
    for (std::size_t i = 0; i < found.regions.size(); ++i) {
        const ManifoldRegion& r = found.regions[i];
        rows.next(i, static_cast<double>(r.kind)), rows.next(i, r.open), rows.next(i, r.normal);
        for (const double number :
             {r.normal_error, r.depth_lower, r.depth_upper, double(r.first), double(r.count), r.area, r.volume, r.lost})
            rows.next(i, number);
        rows.end_row();
    }
    ColumnWriter of_points(results(1), found.points.size(), 11);
    for (std::size_t i = 0; i < found.points.size(); ++i) {
        const ManifoldPoint& p = found.points[i];
        of_points.next(i, p.point_a), of_points.next(i, p.point_b), of_points.next(i, p.normal);
        of_points.next(i, p.depth), of_points.next(i, p.depth_error), of_points.end_row();
    }
    put_offsets(results(2), found.offsets);
    double* const complete = results(3).make(found.complete.size(), 1);
    std::copy(found.complete.begin(), found.complete.end(), complete);
}

} // namespace

/// Verdict, kind, bound.
ONCOLLIDE_WEB int oc_decide(const HeldWorld* held, const double* a, const double* poses_a, const double* b,
                            const double* poses_b, std::size_t count)
{
    return call([=] {
        ColumnWriter rows(results(), count, 3);
        GivenPairs{held, a, b, poses_a, poses_b, count}.each([&](std::size_t i, PairSide one, PairSide other) {
            const Finding found = held->world.pairs().decide(one, other);
            rows.next(i, static_cast<double>(found.verdict)), rows.next(i, static_cast<double>(found.kind));
            rows.next(i, found.bound), rows.end_row();
        });
    });
}
/// Bounds, parts, nearest points.
ONCOLLIDE_WEB int oc_distance(const HeldWorld* held, const double* a, const double* poses_a, const double* b,
                              const double* poses_b, std::size_t count, double tolerance, double cutoff)
{
    return call([=] {
        ColumnWriter rows(results(), count, 10);
        GivenPairs{held, a, b, poses_a, poses_b, count}.each([&](std::size_t i, PairSide one, PairSide other) {
            const Distance found = held->world.pairs().distance(one, other, {.tolerance = tolerance, .cutoff = cutoff});
            rows.next(i, found.lower), rows.next(i, found.upper);
            rows.next(i, number_of_part(found.a)), rows.next(i, number_of_part(found.b));
            rows.next(i, found.point_a), rows.next(i, found.point_b), rows.end_row();
        });
    });
}
/// Parts, kind, the two ends, the two normals of each contact; list 1: offsets.
ONCOLLIDE_WEB int oc_contacts(const HeldWorld* held, const double* a, const double* poses_a, const double* b,
                              const double* poses_b, std::size_t count)
{
    return call([=] {
        std::vector<Contact> all;
        std::vector<std::size_t> offsets{0};
        GivenPairs{held, a, b, poses_a, poses_b, count}.each([&](std::size_t, PairSide one, PairSide other) {
            const std::vector<Contact> found = held->world.pairs().contacts(one, other);
            all.insert(all.end(), found.begin(), found.end());
            offsets.push_back(all.size());
        });
        ColumnWriter rows(results(), all.size(), 15);
        for (std::size_t i = 0; i < all.size(); ++i) put(rows, i, all[i]), rows.end_row();
        put_offsets(results(1), offsets);
    });
}
/// Supported, depth and its upper bound, whose deepest point, bounds and direction of the parting translation, the
/// point.
ONCOLLIDE_WEB int oc_penetration(const HeldWorld* held, const double* a, const double* poses_a, const double* b,
                                 const double* poses_b, std::size_t count)
{
    return call([=] {
        ColumnWriter rows(results(), count, 13);
        GivenPairs{held, a, b, poses_a, poses_b, count}.each([&](std::size_t i, PairSide one, PairSide other) {
            const Penetration found = held->world.pairs().penetration(one, other);
            rows.next(i, found.supported), rows.next(i, found.depth), rows.next(i, found.depth_upper);
            rows.next(i, found.of_a), rows.next(i, found.deepest), rows.next(i, found.thickness);
            rows.next(i, found.parting_lower), rows.next(i, found.parting_upper);
            rows.next(i, found.parting_along), rows.end_row();
        });
    });
}
/// Verdict, kind, three times, gap, point, normal. The motions go from the first poses of each side to its second.
ONCOLLIDE_WEB int oc_sweep(const HeldWorld* held, const double* a, const double* from_a, const double* to_a,
                           const double* b, const double* from_b, const double* to_b, std::size_t count, int path,
                           double time_tolerance, double gap_tolerance, int most_steps, int stop)
{
    return call([=] {
        ColumnWriter rows(results(), count, 12);
        for (std::size_t i = 0; i < count; ++i) {
            const auto moving = [&](double id, const double* from, const double* to) {
                const Eigen::Isometry3d start = pose_at(from, i);
                return MovingModel{held->model(id),
                                   to ? RigidMotion(start, pose_at(to, i), MotionPath(path)) : RigidMotion(start)};
            };
            const SweepResult found = held->world.pairs().sweep(moving(a[i], from_a, to_a), moving(b[i], from_b, to_b),
                                                                {.time_tolerance = time_tolerance,
                                                                 .gap_tolerance = gap_tolerance,
                                                                 .most_steps = most_steps,
                                                                 .stop = static_cast<SweepStop>(stop)});
            rows.next(i, static_cast<double>(found.verdict)), rows.next(i, static_cast<double>(found.kind));
            rows.next(i, found.clear_until), rows.next(i, found.grazes_until), rows.next(i, found.contact_by);
            rows.next(i, found.gap), rows.next(i, found.contact.middle()), rows.next(i, found.normal);
            rows.end_row();
        }
    });
}
/// The largest error of the verdict `within` of each pair.
ONCOLLIDE_WEB int oc_max_error(const HeldWorld* held, const double* a, const double* poses_a, const double* b,
                               const double* poses_b, std::size_t count)
{
    return call([=] {
        double* const to = results().make(count, 1);
        GivenPairs{held, a, b, poses_a, poses_b, count}.each(
            [&](std::size_t i, PairSide one, PairSide other) { to[i] = held->world.pairs().max_error(one, other); });
    });
}
/// The lists of put(ManifoldLists).
ONCOLLIDE_WEB int oc_manifold(const HeldWorld* held, const double* a, const double* poses_a, const double* b,
                              const double* poses_b, std::size_t count, double margin, std::uint32_t points_per_region,
                              std::uint32_t regions_per_pair, bool measures)
{
    return call([=] {
        const ManifoldOptions options{.margin = margin,
                                      .points_per_region = points_per_region,
                                      .regions_per_pair = regions_per_pair,
                                      .measures = measures};
        ManifoldLists all;
        all.offsets = {0};
        GivenPairs{held, a, b, poses_a, poses_b, count}.each([&](std::size_t, PairSide one, PairSide other) {
            const Manifold found = held->world.pairs().manifold(one, other, options);
            for (ManifoldRegion region : found.regions) {
                region.first += static_cast<std::uint32_t>(all.points.size());
                all.regions.push_back(region);
            }
            all.points.insert(all.points.end(), found.points.begin(), found.points.end());
            all.offsets.push_back(all.regions.size()), all.complete.push_back(found.complete);
        });
        put(all);
    });
}
/// The manifolds of the last step. List 4: a and b of each pair.
ONCOLLIDE_WEB int oc_frame_manifolds(HeldWorld* held, double margin, std::uint32_t points_per_region,
                                     std::uint32_t regions_per_pair, bool measures)
{
    return call([=] {
        const FrameManifolds& found = held->world.manifolds({.margin = margin,
                                                             .points_per_region = points_per_region,
                                                             .regions_per_pair = regions_per_pair,
                                                             .measures = measures});
        put(found);
        ColumnWriter rows(results(4), found.pairs.size(), 2);
        for (std::size_t i = 0; i < found.pairs.size(); ++i) {
            rows.next(i, number_of(found.pairs[i].a)), rows.next(i, number_of(found.pairs[i].b));
            rows.end_row();
        }
    });
}
