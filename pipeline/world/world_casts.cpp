// Space: the first points of segments in bodies, safe from many threads at once.
#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/segment_part.hpp>
#include <oncollide/pipeline/world/query_worker.hpp>

namespace oncollide {

namespace {

void check_segments(std::span<const Segment> segments)
{
    check_ends("cast", segments);
    for (std::size_t i = 0; i < segments.size(); ++i)
        if (segments[i].from == segments[i].to)
            throw Error(ErrorKind::bad_data,
                        fmt::format("cast {}: the segment has no length; overlaps() finds the bodies at a point", i));
}

/// A lower bound on the fraction at which a segment enters a box that it may meet.
double entry_into(const Segment& segment, const Aabb& box)
{
    const std::optional<SegmentPart> part = part_in(segment, box);
    if (!part) return 0;
    return std::max(0.0, part->begin - 2 * part->error / (segment.to - segment.from).norm() - 0x1p-40);
}

/// An order of hits that may be first: certain ones before others, then by slots.
auto rank(const CastHit& hit)
{
    return std::pair(hit.verdict != Verdict::colliding, hit.body.slot);
}

} // namespace

/// The first point of the segment in a body, if its fraction may be at most `reach`.
std::optional<CastHit> WorldImpl::cast(QueryWorker& w, std::uint32_t slot, const Segment& segment, double reach)
{
    Model& model = bodies.model(slot);
    const Eigen::Isometry3d& pose = bodies.pose(slot);
    CastHit hit{.body = bodies.id(slot), .verdict = Verdict::undecided, .fraction_upper = 1.0};
    try {
        if (has_tree_for_segments(slot)) {
            const RelativePose into(pose);
            const Segment mine{into(segment.from), into(segment.to)};
            const bool solid = settings.mode == Mode::solid;
            const std::optional<SegmentHit> first =
                models.with_room([&] { return w.segments.first(model, mine, solid, reach); });
            if (!first) return {};
            hit.verdict = first->entry.certain ? Verdict::colliding : Verdict::within;
            hit.fraction_lower = first->entry.lower, hit.fraction_upper = first->entry.upper;
            hit.normal = pose.linear() * first->normal, hit.part = first->part;
        }
    } catch (const ChunkFault& fault) {
        models.note(fault.what());
    }
    if (hit.verdict == Verdict::undecided) hit.fraction_lower = entry_into(segment, bodies.boxes()[slot]);
    const bool certain = hit.verdict == Verdict::colliding;
    const double at = certain ? 0.5 * (hit.fraction_lower + hit.fraction_upper) : hit.fraction_lower;
    hit.point = (1 - at) * segment.from + at * segment.to;
    return hit;
}

/// Leaves in worker.casts all hits of a segment, or only the hits that may be the first.
void WorldImpl::find_casts(QueryWorker& w, const Segment& segment, const CollisionFilter& filter, bool all)
{
    find_boxes(w, segment);
    w.entries.clear(), w.casts.clear();
    for (const AabbHit& hit : w.hits)
        if (allows(filter, hit.body)) w.entries.emplace_back(0.0, hit.body);
    if (w.entries.size() > 1) {
        for (auto& [entry, slot] : w.entries) entry = entry_into(segment, bodies.boxes()[slot]);
        std::ranges::sort(w.entries);
    }
    double reach = 1;
    for (const auto& [entry, slot] : w.entries) {
        if (entry > reach) break;
        const std::optional<CastHit> hit = cast(w, slot, segment, reach);
        if (!hit) continue;
        w.casts.push_back(*hit);
        if (!all && hit->verdict == Verdict::colliding) reach = std::min(reach, hit->fraction_upper);
    }
    std::erase_if(w.casts, [&](const CastHit& hit) { return hit.fraction_lower > reach; });
}

CastHit WorldImpl::first_cast(QueryWorker& w, const Segment& segment, const CollisionFilter& filter)
{
    find_casts(w, segment, filter, false);
    if (w.casts.empty()) return {};
    CastHit first = *std::ranges::min_element(w.casts, {}, rank);
    for (const CastHit& hit : w.casts) {
        first.fraction_lower = std::min(first.fraction_lower, hit.fraction_lower);
        if (hit.verdict == Verdict::colliding)
            first.fraction_upper = std::min(first.fraction_upper, hit.fraction_upper);
    }
    return first;
}

CastHit Space::cast(const Segment& segment, const CollisionFilter& filter) const
{
    WorldImpl& p = *world_;
    check_segments(std::span(&segment, 1));
    p.bring_up_to_date();
    WorldImpl::Lease worker(p);
    return p.first_cast(*worker, segment, filter);
}

void Space::cast(std::span<const Segment> segments, const CollisionFilter& filter, std::span<CastHit> hits) const
{
    WorldImpl& p = *world_;
    same_room("cast", "segments", segments.size(), "hits", hits.size());
    check_segments(segments);
    p.bring_up_to_date();
    p.each(segments.size(), 64,
           [&](auto& worker, std::size_t i) { hits[i] = p.first_cast(worker, segments[i], filter); });
}

std::vector<CastHit> Space::cast_all(const Segment& segment, const CollisionFilter& filter) const
{
    Lists<CastHit> hits;
    cast_all(std::span(&segment, 1), filter, hits);
    return std::move(hits.items);
}

void Space::cast_all(std::span<const Segment> segments, const CollisionFilter& filter, Lists<CastHit>& hits) const
{
    WorldImpl& p = *world_;
    check_segments(segments);
    p.bring_up_to_date();
    p.gather(segments.size(), 64, hits, [&](auto& worker, std::size_t i, auto& list) {
        p.find_casts(worker, segments[i], filter, true);
        std::ranges::sort(worker.casts, {},
                          [](const CastHit& hit) { return std::pair(hit.fraction_lower, hit.body.slot); });
        list.insert(list.end(), worker.casts.begin(), worker.casts.end());
    });
}

} // namespace oncollide
