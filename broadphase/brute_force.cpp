#include <algorithm>

#include <oncollide/broadphase/pair_sort.hpp>
#include <oncollide/broadphase/spatial_tree.hpp>

namespace oncollide {

namespace {

class BruteForce final : public BroadPhase {
public:
    std::string_view name() const override { return "brute"; }

    void find_pairs(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, const BodyFilter& filter,
                    double margin, int, std::vector<BodyPair>& pairs) override
    {
        pairs.clear();
        round_outward(boxes, bodies, filter, margin, boxes_);
        columns_.assign(boxes_);
        const auto count = static_cast<std::uint32_t>(boxes_.size());
        found_.resize(count + 8);
        for (std::uint32_t i = 0; i < count; ++i) {
            const FloatBox& box = boxes_[i];
            const float bounds[6] = {box.lo[0], box.lo[1], box.lo[2], box.hi[0], box.hi[1], box.hi[2]};
            const std::uint32_t hits = box_kernel().overlap_range(columns_.view(), i + 1, count, bounds, found_.data());
            for (std::uint32_t k = 0; k < hits; ++k) {
                const std::uint32_t a = box.body, b = boxes_[found_[k]].body;
                if (filter.allows(a, b)) pairs.push_back({std::min(a, b), std::max(a, b)});
            }
        }
        sort_pairs(pairs, scratch_, filter.is_static.size());
    }

private:
    std::vector<FloatBox> boxes_;
    BoxColumns columns_;
    std::vector<std::uint32_t> found_;
    std::vector<BodyPair> scratch_;
};

} // namespace

std::unique_ptr<BroadPhase> make_brute_force()
{
    return std::make_unique<BruteForce>();
}

} // namespace oncollide
