#include <oncollide/robots/edge_search.hpp>

#include <algorithm>

namespace oncollide {

namespace {

constexpr std::uint32_t most_windows = 64; // of a pair, to begin with
constexpr double first_turn = 1.2;         // rad, in a window of two parts to begin with

/// Calls take(item) for windows in which about as much is done as in `whole` divided by `excess`.
template <class Take>
void each_window(const EdgeItem& whole, double excess, Take take)
{
    std::uint32_t count = 1;
    for (; count < most_windows && excess > 1; excess *= 0.5) count *= 2;
    for (std::uint32_t k = 0; k < count; ++k) {
        EdgeItem item = whole;
        const auto at = [&](std::uint32_t i) { return whole.begin + (whole.end - whole.begin) * i / count; };
        item.begin = at(k), item.end = at(k + 1);
        take(item);
    }
}

} // namespace

EdgeSearch::EdgeSearch(const Robot::Impl& robot, const World& world, const RobotCheck& what, EdgeMotion& motion,
                       const std::vector<std::uint32_t>& own)
    : robot_(robot), world_(world), what_(what), motion_(motion), own_(own)
{
}

std::size_t EdgeSearch::run(std::vector<EdgeItem>& items)
{
    tests_ = 0;
    if (what_.self) search_self(items);
    if (what_.environment && world_.size() > own_.size()) search_environment(items);
    return tests_;
}

void EdgeSearch::search_self(std::vector<EdgeItem>& items)
{
    const std::size_t count = motion_.rigid().size();
    bundles_.resize(std::max(bundles_.size(), count * count));
    for (auto& bundle : bundles_) bundle.clear();
    for (std::uint32_t p = 0; p < robot_.pairs.size(); ++p) {
        const std::uint32_t a = motion_.rigid_of(robot_.pairs[p].a), b = motion_.rigid_of(robot_.pairs[p].b);
        if (a != b) bundles_[a * count + b].push_back(p); // else both ends are tested
    }
    const auto ways_of = [&](const EdgeItem& item) {
        const RigidParts &a = motion_.rigid()[item.a], &b = motion_.rigid()[item.b];
        return EdgeWays{motion_.travel(item, a.ball, a.link), motion_.travel(item, b.ball, b.link)};
    };
    coarse_.clear();
    motion_.place(0.5);
    for (std::uint32_t a = 0; a < count; ++a)
        for (std::uint32_t b = 0; b < count; ++b) {
            const std::vector<std::uint32_t>& bundle = bundles_[a * count + b];
            if (bundle.empty()) continue;
            const Robot::Impl::PartPair& first = robot_.pairs[bundle[0]];
            if (bundle.size() == 1) {
                search_pair({0, 1, first.a, first.b, {}, first.seen_from}, items);
                continue;
            }
            const EdgeItem whole{0, 1, a, b, {}, first.seen_from};
            const double radius = std::min(motion_.rigid()[a].ball.radius, motion_.rigid()[b].ball.radius);
            add_windows(whole, ways_of(whole), radius, coarse_);
        }
    std::ranges::stable_sort(coarse_, {}, &EdgeItem::middle);
    for (const EdgeItem& item : coarse_) {
        const Eigen::Isometry3d* const links = motion_.place(item.middle());
        const RigidParts &a = motion_.rigid()[item.a], &b = motion_.rigid()[item.b];
        const double apart = (links[a.link] * a.ball.centre - links[b.link] * b.ball.centre).norm(),
                     near = motion_.reach(ways_of(item)) + a.ball.radius + b.ball.radius + world_.settings().clearance,
                     size = links[a.link].translation().norm() + links[b.link].translation().norm();
        if (apart > near * (1 + 1e-12) + 1e-12 * size) continue;
        for (const std::uint32_t p : bundles_[item.a * count + item.b]) {
            const Robot::Impl::PartPair& pair = robot_.pairs[p];
            search_pair({item.begin, item.end, pair.a, pair.b, {}, pair.seen_from}, items);
        }
    }
}

/// motion_.place() in the middle of the item comes first.
void EdgeSearch::search_pair(const EdgeItem& whole, std::vector<EdgeItem>& items)
{
    const double radius = std::min(robot_.parts[whole.a].cover.whole.radius, robot_.parts[whole.b].cover.whole.radius);
    add_windows(whole, motion_.ways_of(whole), radius, items);
}

void EdgeSearch::add_windows(const EdgeItem& whole, const EdgeWays& ways, double radius,
                             std::vector<EdgeItem>& items) const
{
    each_window(whole, std::min(motion_.reach(ways) / radius, ways.turned() / first_turn),
                [&](const EdgeItem& item) { items.push_back(item); });
}

/// Queries the World in the windows of items. Coarse windows with bodies are halved.
/// @param prepare  adds the query of an item in the middle of its window, and its reach; returns whether the window is
/// coarse
/// @param take     gets an item whose window is not coarse, and a body
template <class Prepare, class Take>
void EdgeSearch::query(std::vector<EdgeItem>& items, Prepare prepare, Take take)
{
    while (!items.empty()) {
        std::ranges::stable_sort(items, {}, &EdgeItem::middle);
        queries_.clear(), reaches_.clear(), is_coarse_.clear(), halves_.clear();
        for (const EdgeItem& item : items) is_coarse_.push_back(prepare(item, motion_.place(item.middle())));
        world_.near(queries_, reaches_, hits_);
        tests_ += hits_.hits.size();
        for (std::size_t i = 0; i < items.size(); ++i) {
            EdgeItem item = items[i];
            bool halved = false;
            for (std::size_t h = hits_.offsets[i]; h < hits_.offsets[i + 1] && !halved; ++h) {
                item.body = hits_.hits[h].body;
                if (std::ranges::binary_search(own_, item.body.slot)) continue;
                if (is_coarse_[i]) {
                    each_window(items[i], 2, [&](const EdgeItem& half) { halves_.push_back(half); });
                    halved = true;
                } else
                    take(item);
            }
        }
        items.swap(halves_);
    }
}

void EdgeSearch::search_environment(std::vector<EdgeItem>& items)
{
    coarse_.clear(), fine_.clear();
    motion_.place(0.5);
    const std::uint32_t root = robot_.tree.root();
    const std::vector<RigidParts>& all = motion_.rigid();
    for (std::uint32_t k = 0; k < all.size(); ++k) {
        const bool one = all[k].parts.size() == 1;
        const EdgeItem whole{0, 1, one ? all[k].parts[0] : k, no_part, {}, root};
        const double moved = motion_.travel(whole, all[k].ball, all[k].link).moved;
        if (moved > 0) // else both ends are tested
            each_window(whole, 0.5 * moved / all[k].ball.radius,
                        [&](const EdgeItem& item) { (one ? fine_ : coarse_).push_back(item); });
    }
    const auto prepare = [&](ModelId model, const Eigen::Isometry3d& pose, double moved, double radius, double around) {
        queries_.push_back({model, pose, what_.filter});
        reaches_.push_back(moved * robot_.stretch() + around);
        return moved > radius;
    };
    query(
        coarse_,
        [&](const EdgeItem& item, const Eigen::Isometry3d* links) {
            const RigidParts& rigid = all[item.a];
            Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
            pose.translation() = links[rigid.link] * rigid.ball.centre;
            const double radius = rigid.ball.radius;
            return prepare(robot_.point, pose, motion_.travel(item, rigid.ball, rigid.link).moved, radius, radius);
        },
        [&](const EdgeItem& item) {
            const std::vector<std::uint32_t>& parts = all[item.a].parts;
            const bool known = !fine_.empty() && fine_.back().a == parts.back() && fine_.back().begin == item.begin;
            if (known) return; // another body
            for (const std::uint32_t part : parts) fine_.push_back({item.begin, item.end, part, no_part, {}, root});
        });
    query(
        fine_,
        [&](const EdgeItem& item, const Eigen::Isometry3d* links) {
            const Robot::Impl::Part& part = robot_.parts[item.a];
            return prepare(part.model, robot_.pose_of(part, links), motion_.ways_of(item).a.moved,
                           part.cover.whole.radius, 0);
        },
        [&](const EdgeItem& item) { items.push_back(item); });
}

} // namespace oncollide
