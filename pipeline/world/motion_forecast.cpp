#include <oncollide/pipeline/world/motion_forecast.hpp>

#include <algorithm>

namespace oncollide {

bool MotionForecast::found_lately(const PrefetchPart& part) const
{
    const auto known = found_.find(part.model);
    return known != found_.end() && (part.box.min.array() >= known->second.min.array()).all() &&
           (part.box.max.array() <= known->second.max.array()).all();
}

std::vector<PrefetchPart> MotionForecast::find(const BodyTable& bodies, std::span<const std::uint32_t> moved,
                                               const BroadPhase& broad, std::uint32_t frame, std::uint32_t frames)
{
    const std::uint32_t turns = std::max(1u, frames / 2);
    seen_.resize(bodies.slots());
    slots_.clear(), boxes_.clear();
    for (const std::uint32_t slot : moved) {
        if (!bodies.alive(slot) || slot % turns != frame % turns) continue;
        Aabb box = bodies.boxes()[slot];
        Seen& seen = seen_[slot];
        if (seen.frame < frame) {
            const Eigen::Vector3d way = (box.centre() - seen.centre) * (double(frames) / (frame - seen.frame));
            const Aabb there{box.min + way, box.max + way};
            if (way.allFinite() && way.norm() < 1e15) box.add(there.min), box.add(there.max);
        }
        seen = {bodies.boxes()[slot].centre(), frame};
        slots_.push_back(slot), boxes_.push_back(box);
    }
    std::vector<PrefetchPart> parts;
    if (boxes_.empty()) return parts;
    broad.query(bodies.columns(), boxes_, hits_);
    const Eigen::Isometry3d world = Eigen::Isometry3d::Identity();
    for (const AabbHit& hit : hits_) {
        Model& model = bodies.model(hit.body);
        if (!model.cooked() || !bodies.columns().allows(slots_[hit.query], hit.body)) continue;
        parts.push_back({&model, box_moved(boxes_[hit.query], RelativePose(bodies.pose(hit.body), world))});
    }
    if (frame - found_since_ > frames) found_.clear(), found_since_ = frame; // parts found before may have been dropped
    std::erase_if(parts, [&](const PrefetchPart& part) { return found_lately(part); });
    // One part per model: the bounding box of all its parts, enlarged because bodies move on.
    std::ranges::stable_sort(parts, {}, [](const PrefetchPart& part) { return part.model->number(); });
    std::size_t kept = 0;
    for (const PrefetchPart& part : parts) {
        if (kept == 0 || parts[kept - 1].model != part.model)
            parts[kept++] = part;
        else
            parts[kept - 1].box.add(part.box.min), parts[kept - 1].box.add(part.box.max);
    }
    parts.resize(kept);
    for (PrefetchPart& part : parts) {
        const Eigen::Vector3d more = 0.25 * (part.box.max - part.box.min);
        part.box.min -= more, part.box.max += more;
        Aabb& known = found_[part.model];
        known.add(part.box.min), known.add(part.box.max);
    }
    return parts;
}

} // namespace oncollide
