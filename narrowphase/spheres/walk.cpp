#include <oncollide/narrowphase/spheres/walk.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/spheres/walk_kernel.hpp>

namespace oncollide {

static_assert(sizeof(WalkEntry) == Walker::bytes_per_parked);

namespace {

const WalkKernel& kernel()
{
    static const WalkKernel kernel = ONCOLLIDE_CHOOSE(walk_kernel);
    return kernel;
}

// Squares below this would leave float's normal range; equals a distance of 1e-18 m.
constexpr double tiny2 = 1e-36;

double side(unsigned octant, int axis)
{
    return octant >> axis & 1 ? 1.0 : -1.0;
}

/// The levels reached at step s on each side: each step descends the larger sphere, or both if their sizes are within a
/// factor of sqrt 2.
struct Descent {
    double ra, rb;
    int left_a, left_b, level_a = 0, level_b = 0;

    explicit Descent(const WalkPair& pair)
        : ra(pair.a->radius(0)), rb(pair.b->radius(0)), left_a(pair.depth_a), left_b(pair.depth_b)
    {
    }
    bool done() const { return left_a == 0 && left_b == 0; }
    void next(bool& open_a, bool& open_b)
    {
        open_a = left_a > 0 && (left_b == 0 || ra * ra * 2 >= rb * rb);
        open_b = left_b > 0 && (left_a == 0 || rb * rb * 2 >= ra * ra);
        if (open_a) ra *= 0.5, --left_a, ++level_a;
        if (open_b) rb *= 0.5, --left_b, ++level_b;
    }
};

/// Fills the plan. Returns the rounding s: the error bound of float distances.
///
/// Every component is at most m = |d| + |hA| + |hB|. A step adds two offsets, each rounded twice: 4 * 2^-24 m per step.
/// The relative pose is computed in double from the bodies' distance and the files' positions, which may be large and
/// cancel: 2^-48 of these. A pose may be 1e-6 from rigid (2^-20 per body). Squares and sums: 4 * 2^-24 d.
double make_plan(const WalkPair& pair, std::uint32_t frame, WalkPlan& plan)
{
    const Ocst &a = *pair.a, &b = *pair.b;
    const Eigen::Matrix3d to_a = pair.pose_a->linear().transpose();
    const Eigen::Matrix3d turn = to_a * pair.pose_b->linear();
    const Eigen::Vector3d between = pair.pose_b->translation() - pair.pose_a->translation();
    const Eigen::Vector3d d = to_a * between + turn * b.root().centre - a.root().centre;
    for (int axis = 0; axis < 3; ++axis) plan.d[axis] = static_cast<float>(d[axis]);
    for (unsigned k = 0; k < 8; ++k) {
        const auto &ha = a.root().half, &hb = b.root().half;
        plan.ax[k] = static_cast<float>(side(k, 0)) * ha[0];
        plan.ay[k] = static_cast<float>(side(k, 1)) * ha[1];
        plan.az[k] = static_cast<float>(side(k, 2)) * ha[2];
        const Eigen::Vector3d o = turn * Eigen::Vector3d(side(k, 0) * hb[0], side(k, 1) * hb[1], side(k, 2) * hb[2]);
        plan.bx[k] = static_cast<float>(o.x()), plan.by[k] = static_cast<float>(o.y()),
        plan.bz[k] = static_cast<float>(o.z());
    }
    const double m = d.norm() + a.radius(0) + b.radius(0);
    const int most = pair.depth_a + pair.depth_b;
    const double far = between.norm() + a.root().centre.norm() + b.root().centre.norm();
    const double rounding = (4 * most + 80) * 0x1p-24 * m + 0x1p-48 * far;

    plan.count = 0;
    plan.nodes_a = pair.a->nodes(), plan.nodes_b = pair.b->nodes();
    plan.stamp = (frame & OcstNode::stamp_mask) << OcstNode::stamp_shift;
    for (Descent down(pair); !down.done();) {
        bool open_a, open_b;
        down.next(open_a, open_b);
        const double cutoff = down.ra + down.rb + pair.clearance + rounding;
        plan.steps[plan.count++] = {open_a ? static_cast<float>(std::ldexp(1.0, -down.level_a)) : 0.0f,
                                    open_b ? static_cast<float>(std::ldexp(1.0, -down.level_b)) : 0.0f,
                                    static_cast<float>(cutoff * cutoff * (1 + 0x1p-20) + tiny2)};
    }
    return rounding;
}

/// Upper bound of the distance if spheres of the levels reached after `steps` steps touch.
double upper_bound(const WalkPair& pair, int steps, double rounding)
{
    Descent down(pair);
    for (int i = 0; i < steps; ++i) {
        bool open_a, open_b;
        down.next(open_a, open_b);
    }
    const double spheres = 2 * (down.ra + down.rb) + pair.clearance + 2 * rounding;
    return spheres * (1 + 0x1p-19) + pair.a->error(down.level_a) + pair.b->error(down.level_b) + 2 * std::sqrt(tiny2);
}

double lower_bound(const WalkPair& pair, const WalkPlan& plan, const WalkState& state, double rounding)
{
    double lower = infinity;
    Descent down(pair);
    for (int i = 0; i < plan.count; ++i) {
        bool open_a, open_b;
        down.next(open_a, open_b);
        if (state.nearest2[i] < float_infinity)
            lower =
                std::min(lower, std::sqrt(double(state.nearest2[i])) * (1 - 0x1p-21) - down.ra - down.rb - rounding);
    }
    return lower;
}

/// The number of pairs of cells that a traversal sets aside before it parks.
std::uint32_t patience_in(int round, int steps)
{
    constexpr std::uint32_t least = 4;
    return least << std::clamp(round - steps, 0, 20);
}

} // namespace

Walker::Walker() : stack_(walk_stack_room) {}
Walker::~Walker() = default;
Walker::Walker(Walker&&) noexcept = default;

void Walker::park(const WalkEntry* entries, std::size_t count)
{
    if (parked_.size() < parked_used_ + count) parked_.resize(3 * (parked_used_ + count) / 2);
    std::copy_n(entries, count, parked_.begin() + static_cast<std::ptrdiff_t>(parked_used_));
    parked_used_ += count;
}

WalkResult Walker::run(const WalkPair& pair, const WalkPlan& plan, double rounding, std::uint32_t top,
                       double lower_so_far, std::uint32_t patience, bool give_up, ParkedWork& parked)
{
    if (aside_.size() < patience) aside_.resize(patience);
    WalkState state{};
    state.stack = stack_.data(), state.top = top;
    state.parked = aside_.data(), state.parked_room = patience;
    std::fill(state.nearest2, state.nearest2 + plan.count, float_infinity);

    int deepest = -1; // deepest step of the entries given up
    WalkEnd end = kernel().walk(plan, state);
    while (give_up && end == WalkEnd::full) {
        for (std::uint32_t i = 0; i < state.parked_count; ++i) deepest = std::max(deepest, aside_[i].step);
        state.parked_count = 0;
        end = kernel().walk(plan, state);
    }
    node_pairs_ += state.node_pairs;
    parked = {parked_used_, 0, 0};

    if (end == WalkEnd::hit)
        return {WalkStatus::touching, upper_bound(pair, plan.count, rounding), {state.hit_a, state.hit_b}};
    const double lower = std::min(lower_so_far, lower_bound(pair, plan, state, rounding));
    if (give_up)
        for (std::uint32_t i = 0; i < state.parked_count; ++i) deepest = std::max(deepest, aside_[i].step);
    if (deepest >= 0) return {WalkStatus::undecided, upper_bound(pair, deepest, rounding), {}};
    if (state.top == 0 && state.parked_count == 0) return {WalkStatus::separate, std::max(lower, pair.clearance), {}};

    // Parked work is resumed from the end: first the entries set aside, in their order, then the rest of the stack.
    std::reverse(aside_.begin(), aside_.begin() + state.parked_count);
    park(stack_.data(), state.top);
    park(aside_.data(), state.parked_count);
    parked.count = state.top + state.parked_count, parked.wanted = state.parked_count;
    return {WalkStatus::parked, lower, {}};
}

WalkResult Walker::start(const WalkPair& pair, std::uint32_t frame, ParkedWork& parked)
{
    WalkPlan plan;
    const double rounding = make_plan(pair, frame, plan);
    parked = {parked_used_, 0, 0};

    const double root_cutoff = pair.a->radius(0) + pair.b->radius(0) + pair.clearance + rounding;
    const double x = plan.d[0], y = plan.d[1], z = plan.d[2], apart2 = x * x + y * y + z * z;
    if (apart2 > root_cutoff * root_cutoff)
        return {WalkStatus::separate,
                std::max(std::sqrt(apart2) - pair.a->radius(0) - pair.b->radius(0) - rounding, pair.clearance),
                {}};
    if (pair.hint.a && kernel().replay(plan, pair.hint.a, pair.hint.b))
        return {WalkStatus::touching, upper_bound(pair, plan.count, rounding), pair.hint};

    stack_[0] = {0, 0, {plan.d[0], plan.d[1], plan.d[2]}, 0, root_cell, root_cell};
    return run(pair, plan, rounding, 1, infinity, patience_in(0, plan.count), false, parked);
}

WalkResult Walker::resume(const WalkPair& pair, std::uint32_t frame, const Walker& from, const WalkResult& so_far,
                          int round, bool give_up, ParkedWork& parked)
{
    WalkPlan plan;
    const double rounding = make_plan(pair, frame, plan);
    if (stack_.size() < parked.count + walk_stack_room) stack_.resize(parked.count + walk_stack_room);
    std::copy_n(from.parked_.begin() + static_cast<std::ptrdiff_t>(parked.first), parked.count, stack_.begin());
    return run(pair, plan, rounding, static_cast<std::uint32_t>(parked.count), so_far.bound,
               patience_in(round, plan.count), give_up, parked);
}

void Walker::requests(const WalkPair& pair, const ParkedWork& parked, std::vector<CellRequest>& out) const
{
    const std::size_t end = parked.first + parked.count;
    for (std::size_t i = end - parked.wanted; i < end; ++i) {
        const WalkEntry& e = parked_[i];
        Descent down(pair);
        bool open_a = false, open_b = false;
        for (int step = 0; step <= e.step; ++step) down.next(open_a, open_b);
        if (open_a && !pair.a->nodes()[e.a].expanded()) out.push_back({pair.tree_a, e.key_a});
        if (open_b && !pair.b->nodes()[e.b].expanded()) out.push_back({pair.tree_b, e.key_b});
    }
}

} // namespace oncollide
