#include <oncollide/robots/surroundings.hpp>

#include <algorithm>

namespace oncollide {

namespace {

constexpr std::size_t most_together = 64; // bodies: bits of a mask

} // namespace

void GroupCentres::place(std::span<const GroupCover> groups, std::span<const Eigen::Isometry3d> poses,
                         std::size_t links)
{
    origin = poses.front().translation();
    count = static_cast<std::uint32_t>(poses.size() / links), stride = (count + 7) / 8 * 8;
    for (std::vector<float>* column : {&x, &y, &z}) column->resize(groups.size() * stride);
    boxes.assign(groups.size(), {}), sizes.resize(groups.size());
    for (std::size_t g = 0; g < groups.size(); ++g) {
        for (std::uint32_t i = 0; i < count; ++i) {
            const Eigen::Vector3d middle = poses[i * links + groups[g].link()] * groups[g].whole().centre,
                                  at = middle - origin;
            boxes[g].add(middle);
            const std::size_t k = g * stride + i;
            x[k] = static_cast<float>(at.x()), y[k] = static_cast<float>(at.y()), z[k] = static_cast<float>(at.z());
        }
        sizes[g] = (boxes[g].min - origin).cwiseAbs().cwiseMax((boxes[g].max - origin).cwiseAbs()).sum();
    }
}

void Surroundings::begin(const CollisionFilter& filter, std::vector<std::uint32_t> own, const CopiedBodies* copied)
{
    filter_ = filter, own_ = std::move(own);
    copied_.begin(tests_, copied, filter);
    if (!copied) return;
    own_.insert(own_.end(), copied->sorted().begin(), copied->sorted().end());
    std::ranges::sort(own_);
}

bool Surroundings::is_own(std::uint32_t slot) const
{
    return std::ranges::binary_search(own_, slot);
}

std::uint32_t PlacedBodies::number_of(std::uint32_t slot)
{
    const auto [at, is_new] = numbers_.try_emplace(slot, static_cast<std::uint32_t>(bodies_.size()));
    if (is_new) {
        const Model& model = tests_.model_at(slot);
        bodies_.emplace_back(slot, model.geometry(), model.bounds().box(Eigen::Isometry3d::Identity()),
                             tests_.pose_at(slot));
    }
    return at->second;
}

void Surroundings::prepare(const GroupCentres& centres, const NearParts& near, std::size_t first)
{
    centres_ = &centres, parts_ = &near;
    copied_.place(first, centres.count);
    queries_.clear(), bodies_.clear();
    around_.resize(groups_.size());
    for (auto& list : around_) list.clear();
    for (std::size_t g = 0; g < around_.size(); ++g) {
        const Eigen::Vector3d radius = Eigen::Vector3d::Constant(near.radius(groups_[g]));
        queries_.push_back({centres.boxes[g].min - radius, centres.boxes[g].max + radius});
    }
    for (const AabbHit& hit : tests_.around(queries_, filter_))
        if (around_[hit.query].size() <= most_together && !is_own(hit.body))
            around_[hit.query].push_back(bodies_.number_of(hit.body));
}

std::span<const Surroundings::Near> Surroundings::find(std::uint32_t group, std::span<const std::uint8_t> open)
{
    near_.clear();
    if (around_[group].size() <= most_together)
        find_together(group, open);
    else
        find_one_by_one(group, open);
    if (!copied_.is_empty()) find_copied(group, open);
    return near_;
}

void Surroundings::find_copied(std::uint32_t group, std::span<const std::uint8_t> open)
{
    const std::size_t others = near_.size();
    const BallColumns middles = centres_->of(group);
    const double slack = 0x1p-22 * centres_->sizes[group]; // of the middles, which are floats
    each_bit(open, [&](std::uint32_t i) {
        const Eigen::Vector3d middle = centres_->origin + Eigen::Vector3d(middles.x[i], middles.y[i], middles.z[i]);
        copied_.each_near(
            i, middle, centres_->origin,
            [&](const PlacedBox& box, double size) {
                return slack + double(parts_->reach(groups_[group], box, size + centres_->sizes[group]));
            },
            [&](std::uint32_t k) {
                near_.push_back({i, k | is_copied});
            });
    });
    if (others && others < near_.size()) std::ranges::stable_sort(near_, {}, &Near::configuration);
}

void Surroundings::find_together(std::uint32_t group, std::span<const std::uint8_t> open)
{
    const std::vector<std::uint32_t>& around = around_[group];
    if (around.empty()) return;
    Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();
    origin.translation() = centres_->origin;
    masks_.assign(centres_->stride, 0), bits_.resize(open.size());
    for (std::size_t k = 0; k < around.size(); ++k) {
        const PlacedBox& box = bodies_[around[k]].box;
        BallFrame frame;
        set_frame(origin, box.pose, box.centre, frame);
        const float half[3] = {above(box.half.x()), above(box.half.y()), above(box.half.z())};
        const double size = centres_->sizes[group] + (centres_->origin - box.pose.translation()).cwiseAbs().sum() +
                            box.centre.cwiseAbs().sum();
        const float reach = parts_->reach(groups_[group], box, size);
        ball_kernel().points_near_box(centres_->of(group), centres_->stride, frame, half, reach, bits_.data());
        for (std::size_t i = 0; i < open.size(); ++i) bits_[i] &= open[i];
        each_bit(bits_, [&](std::uint32_t i) { masks_[i] |= std::uint64_t{1} << k; });
    }
    for (std::uint32_t i = 0; i < centres_->count; ++i)
        for (std::uint64_t mask = masks_[i]; mask; mask &= mask - 1)
            near_.push_back({i, around[static_cast<std::size_t>(std::countr_zero(mask))]});
}

/// Queries each configuration: a box around all of them overlaps too many bodies.
void Surroundings::find_one_by_one(std::uint32_t group, std::span<const std::uint8_t> open)
{
    queries_.clear(), of_.clear();
    const BallColumns middles = centres_->of(group);
    const double radius = parts_->radius(groups_[group]) + 0x1p-22 * centres_->sizes[group];
    each_bit(open, [&](std::uint32_t i) {
        const Eigen::Vector3d middle = centres_->origin + Eigen::Vector3d(middles.x[i], middles.y[i], middles.z[i]);
        queries_.push_back({middle.array() - radius, middle.array() + radius}), of_.push_back(i);
    });
    for (const AabbHit& hit : tests_.around(queries_, filter_))
        if (!is_own(hit.body)) near_.push_back({of_[hit.query], bodies_.number_of(hit.body)});
}

} // namespace oncollide
