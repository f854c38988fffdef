#include <oncollide/robots/group_cover.hpp>

#include <algorithm>
#include <numeric>

#include <oncollide/base/simd/cpu_features.hpp>

namespace oncollide {

namespace {

constexpr float nowhere = 1e18f;
// Share of the coordinates that covers the kernel's arithmetic and rounding to float.
constexpr double float_slack = 0x1p-19;

/// Orders [begin, end) so that each run of eight is close together.
template <class Iterator, class Centre>
void sort_into_blocks(Iterator begin, Iterator end, Centre centre)
{
    const auto count = end - begin;
    if (count <= 8) return;
    Aabb box;
    for (Iterator i = begin; i != end; ++i) box.add(centre(*i));
    Eigen::Index axis = 0;
    (box.max - box.min).maxCoeff(&axis);
    const Iterator middle = begin + (count / 2 + 7) / 8 * 8;
    std::nth_element(begin, middle, end, [&](auto a, auto b) { return centre(a)[axis] < centre(b)[axis]; });
    sort_into_blocks(begin, middle, centre), sort_into_blocks(middle, end, centre);
}

} // namespace

const BallKernel& ball_kernel()
{
    static const BallKernel kernel = ONCOLLIDE_CHOOSE_TO_AVX2(ball_kernel);
    return kernel;
}

void BallList::push_back(const CoverSphere& ball)
{
    x.push_back(static_cast<float>(ball.centre.x())), y.push_back(static_cast<float>(ball.centre.y()));
    z.push_back(static_cast<float>(ball.centre.z())), radius.push_back(above(ball.radius));
}

void BallList::pad(std::size_t multiple)
{
    while (size() % multiple) x.push_back(nowhere), y.push_back(0), z.push_back(0), radius.push_back(0);
}

GroupCover::GroupCover(std::span<const CoverSphere> spheres, std::span<const std::uint32_t> parts,
                       const CoverSphere& whole, std::uint32_t link)
    : one_part_(std::ranges::adjacent_find(parts, std::not_equal_to{}) == parts.end()), whole_(whole), link_(link)
{
    std::vector<std::uint32_t> order(spheres.size());
    std::iota(order.begin(), order.end(), 0u);
    sort_into_blocks(order.begin(), order.end(), [&](std::uint32_t i) { return spheres[i].centre; });
    for (const CoverSphere& sphere : spheres)
        box_.add(sphere.centre.array() - sphere.radius), box_.add(sphere.centre.array() + sphere.radius);
    std::vector<CoverSphere> block;
    for (std::size_t i = 0; i < order.size(); ++i) {
        balls_.push_back(spheres[order[i]]), parts_.push_back(parts[order[i]]), block.push_back(spheres[order[i]]);
        if (block.size() < 8 && i + 1 < order.size()) continue;
        around_.push_back(around_spheres(block));
        block.clear();
    }
    balls_.pad(8), around_.pad(8);
}

BallBlocks GroupCover::blocks() const
{
    return {balls_.columns(), around_.columns(), static_cast<std::uint32_t>(balls_.size() / 8)};
}

NearParts::NearParts(double stretch, double clearance)
    : factor_(stretch * (1 + 2e-6 + float_slack)), clearance_(clearance * (1 + 2e-6 + float_slack)),
      turn_(2 * (stretch - 1) + 4e-6 + float_slack)
{
}

void set_frame(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, const Eigen::Vector3d& point,
               BallFrame& frame)
{
    const Eigen::Matrix3d rotation = to.linear().transpose() * from.linear();
    const Eigen::Vector3d shift = to.linear().transpose() * (from.translation() - to.translation()) - point;
    for (int row = 0; row < 3; ++row) {
        for (int k = 0; k < 3; ++k) frame[4 * row + k] = static_cast<float>(rotation(row, k));
        frame[4 * row + 3] = static_cast<float>(shift[row]);
    }
}

void NearParts::find(const GroupCover& a, const Eigen::Isometry3d& link_a, const GroupCover& b,
                     const Eigen::Isometry3d& link_b, std::vector<std::uint64_t>& pairs)
{
    constexpr BallFrame as_it_is{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const double apart = (link_a.translation() - link_b.translation()).cwiseAbs().sum();
    const double slack = turn_ * (a.size() + b.size() + apart);
    const BallGrowth with_clearance{above(factor_), above(slack + clearance_)}, growth{above(factor_), above(slack)};
    near_a_.resize(a.balls()), near_b_.resize(b.balls());
    BallFrame frame; // into the frame of b's box
    const Eigen::Vector3d middle = b.box().centre(), half = b.box().half_extent() * factor_;
    set_frame(link_a, link_b, middle, frame);
    const float box[3] = {above(half.x()), above(half.y()), above(half.z())};
    const BallBlocks blocks_b = b.blocks();
    const std::uint32_t count = ball_kernel().balls_near_box(a.blocks(), frame, box, with_clearance, near_a_.data());
    for (int row = 0; row < 3; ++row) frame[4 * row + 3] += static_cast<float>(middle[row]);
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t k = near_a_[i];
        const float x = a.list().x[k], y = a.list().y[k], z = a.list().z[k];
        float ball[4];
        for (int row = 0; row < 3; ++row)
            ball[row] = frame[4 * row] * x + frame[4 * row + 1] * y + frame[4 * row + 2] * z + frame[4 * row + 3];
        ball[3] = above(a.list().radius[k] * factor_ + clearance_);
        const std::uint32_t found = ball_kernel().balls_near_ball(blocks_b, as_it_is, ball, growth, near_b_.data());
        for (std::uint32_t n = 0; n < found; ++n) {
            pairs.push_back(std::uint64_t{a.part(k)} << 32 | b.part(near_b_[n]));
            if (a.has_one_part() && b.has_one_part()) return;
        }
    }
}

void NearParts::find(const GroupCover& a, const Eigen::Isometry3d& link_a, const PlacedBox& box,
                     std::vector<std::uint32_t>& parts)
{
    const double apart = (link_a.translation() - box.pose.translation()).cwiseAbs().sum();
    const double size = a.size() + apart + box.centre.cwiseAbs().sum() + box.half.sum();
    const BallGrowth growth{above(factor_), above(clearance_ + turn_ * size)};
    const float half[3] = {above(box.half.x()), above(box.half.y()), above(box.half.z())};
    near_a_.resize(a.balls());
    BallFrame frame;
    set_frame(link_a, box.pose, box.centre, frame);
    const std::uint32_t count = ball_kernel().balls_near_box(a.blocks(), frame, half, growth, near_a_.data());
    for (std::uint32_t i = 0; i < count; ++i) {
        parts.push_back(a.part(near_a_[i]));
        if (a.has_one_part()) return;
    }
}

float NearParts::reach(const GroupCover& a, const GroupCover& b, double size) const
{
    return above((a.whole().radius + b.whole().radius) * factor_ + clearance_ + float_slack * size);
}

float NearParts::reach(const GroupCover& a, const PlacedBox& box, double size) const
{
    return above(radius(a) + turn_ * (size + box.half.sum()));
}

} // namespace oncollide
