#include <algorithm>
#include <array>

#include <oncollide/base/outward.hpp>
#include <oncollide/broadphase/box_kernel.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/pair_sort.hpp>
#include <oncollide/broadphase/tree_search.hpp>

namespace oncollide {

namespace {

/// Eight boxes at a time in float, rounded outward; the boxes themselves decide.
class BruteForce final : public BroadPhase {
public:
    std::string_view name() const override { return "brute"; }

    void find_pairs(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, const BodyFilter& filter,
                    double margin, int, std::vector<BodyPair>& pairs) override
    {
        pairs.clear();
        refuse_unusable(boxes, bodies);
        round_outward(boxes, bodies, margin);
        const auto count = static_cast<std::uint32_t>(bodies.size());
        found_.resize(count + 8);
        const BoxColumnsView columns{{columns_[0].data(), columns_[1].data(), columns_[2].data()},
                                     {columns_[3].data(), columns_[4].data(), columns_[5].data()}};
        for (std::uint32_t i = 0; i < count; ++i) {
            float box[6];
            for (std::size_t c = 0; c < 6; ++c) box[c] = columns_[c][i];
            const std::uint32_t hits = box_kernel().overlap_range(columns, i + 1, count, box, found_.data());
            for (std::uint32_t k = 0; k < hits; ++k) {
                const std::uint32_t a = bodies[i], b = bodies[found_[k]];
                if (filter.allows(a, b) && overlap(boxes[a], boxes[b], margin))
                    pairs.push_back({std::min(a, b), std::max(a, b)});
            }
        }
        sort_pairs(pairs, scratch_, filter.is_static.size());
    }

private:
    /// Relative to the middle of all; padded so that the kernel may read past the end.
    void round_outward(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin)
    {
        Aabb all;
        for (std::uint32_t body : bodies) all.add(boxes[body]);
        const Eigen::Vector3d origin = bodies.empty() ? Eigen::Vector3d::Zero().eval() : all.centre();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            std::vector<float>&lo = columns_[axis], &hi = columns_[3 + axis];
            lo.resize(bodies.size() + 8), hi.resize(bodies.size() + 8);
            const auto k = static_cast<Eigen::Index>(axis);
            for (std::size_t i = 0; i < bodies.size(); ++i) {
                lo[i] = below(boxes[bodies[i]].min[k] - 0.5 * margin - origin[k]);
                hi[i] = above(boxes[bodies[i]].max[k] + 0.5 * margin - origin[k]);
            }
        }
    }

    std::array<std::vector<float>, 6> columns_; ///< lo x y z, hi x y z
    std::vector<std::uint32_t> found_;
    std::vector<BodyPair> scratch_;
};

} // namespace

std::unique_ptr<BroadPhase> make_brute_force()
{
    return std::make_unique<BruteForce>();
}

} // namespace oncollide
