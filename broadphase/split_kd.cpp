#include <algorithm>
#include <array>

#include <oncollide/broadphase/spatial_tree.hpp>

namespace oncollide {

namespace {

/// Splits at the mean of the centres along the axis on which they vary most.
class KdSplitter final : public NodeSplitter {
public:
    std::span<const std::uint32_t> split(std::span<FloatBox> boxes) override
    {
        double sum[3] = {}, squares[3] = {};
        for (const FloatBox& box : boxes)
            for (int axis = 0; axis < 3; ++axis) {
                const double c = 0.5 * (double(box.lo[axis]) + box.hi[axis]);
                sum[axis] += c, squares[axis] += c * c;
            }
        const double n = static_cast<double>(boxes.size());
        int axis = 0;
        double widest = -1;
        for (int k = 0; k < 3; ++k) {
            const double variance = squares[k] - sum[k] * sum[k] / n;
            if (variance > widest) widest = variance, axis = k;
        }
        const auto plane = static_cast<float>(sum[axis] / n);

        const auto straddles = [&](const FloatBox& b) { return b.lo[axis] <= plane && b.hi[axis] >= plane; };
        const auto is_low = [&](const FloatBox& b) { return b.hi[axis] < plane; };
        const auto rest = std::partition(boxes.begin(), boxes.end(), straddles);
        const auto high = std::partition(rest, boxes.end(), is_low);
        begins_ = {static_cast<std::uint32_t>(rest - boxes.begin()), static_cast<std::uint32_t>(high - boxes.begin())};
        // A plane that most boxes straddle separates little: testing them all against each other is cheaper.
        if (begins_[0] * 4ull > boxes.size() * 3ull) return {};
        return begins_;
    }

private:
    std::array<std::uint32_t, 2> begins_{};
};

} // namespace

std::unique_ptr<NodeSplitter> make_kd_splitter()
{
    return std::make_unique<KdSplitter>();
}

} // namespace oncollide
