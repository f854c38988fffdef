#include <algorithm>
#include <array>
#include <vector>

#include <oncollide/broadphase/spatial_tree.hpp>

namespace oncollide {

namespace {

/// Splits at the mean of the centres on all three axes; group 0 straddles, group 1 + k is octant k.
class OctreeSplitter final : public NodeSplitter {
public:
    std::span<const std::uint32_t> split(std::span<FloatBox> boxes) override
    {
        double sum[3] = {};
        for (const FloatBox& box : boxes)
            for (int axis = 0; axis < 3; ++axis) sum[axis] += 0.5 * (double(box.lo[axis]) + box.hi[axis]);
        float middle[3];
        for (int axis = 0; axis < 3; ++axis)
            middle[axis] = static_cast<float>(sum[axis] / static_cast<double>(boxes.size()));

        const auto group = [&](const FloatBox& box) {
            unsigned octant = 0;
            for (int axis = 0; axis < 3; ++axis) {
                if (box.lo[axis] > middle[axis])
                    octant |= 1u << axis;
                else if (box.hi[axis] >= middle[axis])
                    return 0u;
            }
            return 1 + octant;
        };
        std::array<std::uint32_t, 10> starts{};
        for (const FloatBox& box : boxes) ++starts[group(box) + 1];
        if (starts[1] * 8ull > boxes.size() * 7ull) return {};
        for (std::size_t g = 1; g < starts.size(); ++g) starts[g] += starts[g - 1];
        scratch_.resize(boxes.size());
        for (std::size_t c = 0; c < begins_.size(); ++c) begins_[c] = starts[c + 1];
        for (const FloatBox& box : boxes) scratch_[starts[group(box)]++] = box;
        std::copy(scratch_.begin(), scratch_.end(), boxes.begin());
        return begins_;
    }

private:
    std::array<std::uint32_t, 8> begins_{};
    std::vector<FloatBox> scratch_;
};

} // namespace

std::unique_ptr<NodeSplitter> make_octree_splitter()
{
    return std::make_unique<OctreeSplitter>();
}

} // namespace oncollide
