#include <algorithm>
#include <array>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/outward.hpp>
#include <oncollide/broadphase/aabb_checks.hpp>
#include <oncollide/broadphase/aabb_kernel.hpp>
#include <oncollide/broadphase/body_states.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/segment_part.hpp>

namespace oncollide {

namespace {

/// Compares eight boxes at a time in float, rounded outward, and the hits again in double.
class BruteForce final : public TracksBodies {
public:
    explicit BruteForce(const Options& options) : TracksBodies(options) {}
    std::string_view name() const override { return "brute"; }

    void take_in(const BodyColumns& columns) override
    {
        bodies_.check(columns);
        if (taken_in_) return;
        bodies_.list(list_);
        refuse_unusable(columns.boxes, list_);
        round_outward(columns.boxes);
        bodies_.forget_changes();
        taken_in_ = true;
    }

    std::span<const BodyPair> find_pairs(const BodyColumns& columns, bool) override
    {
        take_in(columns);
        pairs_.clear();
        const auto count = static_cast<std::uint32_t>(list_.size());
        ONCOLLIDE_ASSERT(columns_[0].size() == list_.size() + 8);
        found_.resize(count + 8);
        const AabbColumnsView view{{columns_[0].data(), columns_[1].data(), columns_[2].data()},
                                   {columns_[3].data(), columns_[4].data(), columns_[5].data()}};
        for (std::uint32_t i = 0; i < count; ++i) {
            float box[6];
            for (std::size_t c = 0; c < 6; ++c) box[c] = columns_[c][i];
            const std::uint32_t hits = aabb_kernel().overlap_range(view, i + 1, count, box, found_.data());
            for (std::uint32_t k = 0; k < hits; ++k) {
                const std::uint32_t a = list_[i], b = list_[found_[k]];
                const bool dynamic = bodies_.is(a, BodyStates::dynamic) || bodies_.is(b, BodyStates::dynamic);
                if (dynamic && columns.allows(a, b) && overlap(columns.boxes[a], columns.boxes[b], options_.margin))
                    pairs_.push_back({a, b});
            }
        }
        return pairs_;
    }

    void survivors(std::vector<std::uint32_t>& bodies) override { bodies_.list(bodies); }

    void query(const BodyColumns& columns, std::span<const Aabb> boxes, std::vector<AabbHit>& hits) const override
    {
        check_query(columns), refuse_unusable_queries(boxes);
        hits.clear();
        for (std::uint32_t k = 0; k < boxes.size(); ++k)
            for (std::uint32_t body : list_)
                if (overlap(boxes[k], columns.boxes[body], options_.margin)) hits.push_back({k, body});
    }

    void query_segments(const BodyColumns& columns, std::span<const Segment> segments,
                        std::vector<AabbHit>& hits) const override
    {
        check_query(columns), refuse_unusable_queries(segments);
        hits.clear();
        for (std::uint32_t k = 0; k < segments.size(); ++k)
            for (std::uint32_t body : list_)
                if (part_in(segments[k], grown(columns.boxes[body], options_.margin))) hits.push_back({k, body});
    }

    std::size_t bytes() const override
    {
        std::size_t sum = bodies_.bytes() + (list_.capacity() + found_.capacity()) * sizeof(std::uint32_t) +
                          pairs_.capacity() * sizeof(BodyPair);
        for (const std::vector<float>& column : columns_) sum += column.capacity() * sizeof(float);
        return sum;
    }

private:
    /// Converts to float relative to the centre of all boxes; padded so that the kernel may read past the end.
    void round_outward(std::span<const Aabb> boxes)
    {
        Aabb all;
        for (std::uint32_t body : list_) all.add(boxes[body]);
        const Eigen::Vector3d origin = list_.empty() ? Eigen::Vector3d::Zero().eval() : all.centre();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::vector<float>&lo = columns_[axis], &hi = columns_[3 + axis];
            lo.resize(list_.size() + 8), hi.resize(list_.size() + 8);
            const auto k = static_cast<Eigen::Index>(axis);
            for (std::size_t i = 0; i < list_.size(); ++i) {
                lo[i] = below(boxes[list_[i]].min[k] - 0.5 * options_.margin - origin[k]);
                hi[i] = above(boxes[list_[i]].max[k] + 0.5 * options_.margin - origin[k]);
            }
        }
    }

    std::vector<std::uint32_t> list_;           ///< bodies present, ascending
    std::array<std::vector<float>, 6> columns_; ///< their boxes: lo x y z, hi x y z
    std::vector<std::uint32_t> found_;
    std::vector<BodyPair> pairs_;
};

} // namespace

std::unique_ptr<BroadPhase> make_brute_force(const BroadPhase::Options& options)
{
    return std::make_unique<BruteForce>(options);
}

} // namespace oncollide
