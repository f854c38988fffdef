#include <oncollide/broadphase/delimitation.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace oncollide {

namespace {

constexpr std::size_t leaf_bodies = 16;
constexpr int deepest = 20;

/// Where to cut, and how many bodies the cut leaves on both sides.
struct Cut {
    int axis = -1;
    double plane = 0;
    double cost = std::numeric_limits<double>::infinity();
};

} // namespace

std::string_view Delimitation::reason_to_skip(const BodyFilter& filter)
{
    const std::size_t n = filter.is_static.size();
    if (n < 64) return "fewer than 64 bodies";
    const auto statics = static_cast<std::size_t>(std::count(filter.is_static.begin(), filter.is_static.end(), 1));
    if (statics * 4 < n * 3) return "over a quarter of the bodies may move";
    return {};
}

void Delimitation::split(std::uint32_t region, std::vector<std::uint32_t>& bodies, const Aabb& space, int depth,
                         std::span<const Aabb> boxes, const BodyFilter& filter, double margin)
{
    Region made;
    made.volume = space.volume();
    for (std::uint32_t body : bodies)
        if (filter.is_static[body]) {
            ++made.statics, made.layers |= filter.layers[body], made.masks |= filter.masks[body];
        }

    // The plane through a body's low face that balances best and cuts least. Faces are sampled at the 1/16 quantiles.
    Cut best;
    if (bodies.size() > leaf_bodies && depth < deepest) {
        for (int axis = 0; axis < 3; ++axis) {
            ends_.clear();
            for (std::uint32_t body : bodies) ends_.push_back(boxes[body].min[axis] - 0.5 * margin);
            std::sort(ends_.begin(), ends_.end());
            for (int k = 4; k <= 12; ++k) {
                const double face = ends_[ends_.size() * static_cast<std::size_t>(k) / 16];
                const double plane = std::nextafter(face, -std::numeric_limits<double>::infinity());
                double low = 0, high = 0;
                for (std::uint32_t body : bodies) {
                    low += boxes[body].min[axis] - 0.5 * margin <= plane;
                    high += boxes[body].max[axis] + 0.5 * margin >= plane;
                }
                const double n = static_cast<double>(bodies.size());
                const double cost = low * low + high * high;
                if (cost < best.cost && low < n && high < n && low + high < 1.5 * n) best = {axis, plane, cost};
            }
        }
    }
    if (best.axis < 0) {
        made.first = static_cast<std::uint32_t>(static_bodies_.size());
        for (std::uint32_t body : bodies)
            if (filter.is_static[body]) static_bodies_.push_back(body);
        made.count = static_cast<std::uint32_t>(static_bodies_.size()) - made.first;
        regions_[region] = made;
        return;
    }
    made.axis = best.axis, made.plane = best.plane;
    made.children = static_cast<std::uint32_t>(regions_.size());
    regions_.resize(regions_.size() + 2);
    regions_[region] = made;
    for (int side = 0; side < 2; ++side) {
        std::vector<std::uint32_t> part;
        for (std::uint32_t body : bodies)
            if (side == 0 ? boxes[body].min[best.axis] - 0.5 * margin <= best.plane
                          : boxes[body].max[best.axis] + 0.5 * margin >= best.plane)
                part.push_back(body);
        Aabb half = space;
        (side == 0 ? half.max : half.min)[best.axis] = best.plane;
        split(made.children + static_cast<std::uint32_t>(side), part, half, depth + 1, boxes, filter, margin);
    }
}

void Delimitation::build(std::span<const Aabb> boxes, const BodyFilter& filter, double margin)
{
    regions_.assign(1, {});
    static_bodies_.clear();
    std::vector<std::uint32_t> all(boxes.size());
    Aabb space;
    mover_list_.clear();
    for (std::uint32_t body = 0; body < all.size(); ++body) {
        all[body] = body;
        space.add(boxes[body]);
        if (!filter.is_static[body]) mover_list_.push_back(body);
    }
    split(0, all, space, 0, boxes, filter, margin);
    const double whole = regions_[0].volume;
    for (Region& region : regions_) region.volume = whole > 0 ? region.volume / whole : 0;
    survives_.assign(boxes.size(), 0);
    built_ = true;
    placed_when_built_ = 0;
}

void Delimitation::visit(std::uint32_t index, std::size_t level, std::size_t first_mover, std::span<const Aabb> boxes,
                         const BodyFilter& filter, double half_margin, std::vector<std::uint32_t>& survivors)
{
    const Region& region = regions_[index];
    const std::size_t last = movers_.size(), count = last - first_mover;
    if (levels_.size() <= level) levels_.resize(level + 1);
    ++levels_[level].regions;

    std::uint32_t mover_layers = 0, mover_masks = 0;
    for (std::size_t i = first_mover; i < last; ++i)
        mover_layers |= filter.layers[movers_[i]], mover_masks |= filter.masks[movers_[i]];
    // A mover alone has only the static bodies to meet.
    const std::uint32_t other_layers = region.layers | (count > 1 ? mover_layers : 0);
    const std::uint32_t other_masks = region.masks | (count > 1 ? mover_masks : 0);
    const bool layers_meet = (other_layers & mover_masks) && (mover_layers & other_masks);
    if (count == 0 || count + region.statics < 2 || !layers_meet) {
        ++levels_[level].regions_rejected;
        levels_[level].bodies_rejected += count + region.statics;
        levels_[level].volume_rejected += region.volume;
        return;
    }
    const auto keep = [&](std::uint32_t body) {
        if (!survives_[body]) survives_[body] = 1, survivors.push_back(body);
    };
    if (region.axis < 0) {
        placed_ += count;
        for (std::uint32_t i = 0; i < region.count; ++i) keep(static_bodies_[region.first + i]);
        for (std::size_t i = first_mover; i < last; ++i) keep(movers_[i]);
        return;
    }
    for (int side = 0; side < 2; ++side) {
        for (std::size_t i = first_mover; i < last; ++i) {
            const Aabb& box = boxes[movers_[i]];
            if (side == 0 ? box.min[region.axis] - half_margin <= region.plane
                          : box.max[region.axis] + half_margin >= region.plane)
                movers_.push_back(movers_[i]);
        }
        visit(region.children + static_cast<std::uint32_t>(side), level + 1, last, boxes, filter, half_margin,
              survivors);
        movers_.resize(last);
    }
}

void Delimitation::run(std::span<const Aabb> boxes, const BodyFilter& filter, double margin,
                       std::vector<std::uint32_t>& survivors)
{
    // Movers that gathered make leaves long; a fresh hierarchy tells them apart again.
    if (!built_ || (placed_when_built_ && placed_ > 2 * placed_when_built_ + 64)) build(boxes, filter, margin);
    survivors.clear();
    levels_.clear();
    placed_ = 0;
    movers_ = mover_list_;
    visit(0, 0, 0, boxes, filter, 0.5 * margin, survivors);
    if (!placed_when_built_) placed_when_built_ = std::max<std::uint64_t>(placed_, 1);
    std::sort(survivors.begin(), survivors.end());
    for (std::uint32_t body : survivors) survives_[body] = 0;
}

} // namespace oncollide
