#include <oncollide/robots/edges/edge_search.hpp>

#include <algorithm>

namespace oncollide {

namespace {

constexpr std::uint32_t most_windows = 64; // windows of a pair at the beginning
constexpr double first_turn = 1.2;         // radians: rotation in a first window of two parts
constexpr double window_turn = 0.4;        // radians: rotation in a window of a part and bodies

/// Divides `whole` into windows in which the motion is about 1 / `excess` of the whole, and calls take(item) for each.
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

EdgeSearch::EdgeSearch(const Robot::Impl& robot, const World& world, const RobotCheck& what,
                       const Clearances& clearances, EdgeMotion& motion, EdgeCull& cull,
                       const std::vector<std::uint32_t>& own)
    : robot_(robot), world_(world), what_(what), clearances_(clearances), motion_(motion), cull_(cull),
      cells_(robot.joint_cells(world.settings().clearance)), own_(own)
{
}

void EdgeSearch::run(std::vector<EdgeItem>& items)
{
    if (what_.self) search_self(items);
    if (what_.environment && world_.bodies().size() > own_.size()) search_environment(items);
}

void EdgeSearch::search_self(std::vector<EdgeItem>& items)
{
    const std::size_t count = motion_.rigid().size();
    bundles_.resize(std::max(bundles_.size(), count * count));
    for (auto& bundle : bundles_) bundle.clear();
    for (std::uint32_t p = 0; p < robot_.pairs.size(); ++p) {
        const Robot::Impl::PartPair& pair = robot_.pairs[p];
        const std::uint32_t a = motion_.rigid_of(pair.a), b = motion_.rigid_of(pair.b);
        if (a == b) continue; // both ends are tested
        if (!cells_->covers(p)) {
            bundles_[a * count + b].push_back(p);
            continue;
        }
        cells_->each_open(world_, p, motion_.from(), motion_.to(), scratch_, [&](double begin, double end) {
            motion_.place(0.5 * (begin + end));
            search_pair({begin, end, pair.a, pair.b, {}, pair.seen_from}, items);
        });
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
                     near = motion_.reach(ways_of(item)) + a.ball.radius + b.ball.radius + clearances_.most_of_links(),
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

/// Tests the ball around rigid parts against the boxes of bodies in equal windows, then the solids of its parts.
void EdgeSearch::search_environment(std::vector<EdgeItem>& items)
{
    const std::uint32_t root = robot_.tree.root();
    const std::vector<RigidParts>& all = motion_.rigid();
    motion_.place(0.5);
    double excess = 0; // windows that the fastest parts need
    for (const RigidParts& rigid : all) {
        const BallTravel way = motion_.travel({0, 1, 0, no_part, {}, root}, rigid.ball, rigid.link);
        excess = std::max({excess, way.turned / window_turn, 0.5 * way.moved / rigid.ball.radius * (way.turned == 0)});
    }
    windows_ = 1;
    while (windows_ < most_windows && windows_ < excess) windows_ *= 2;
    balls_.resize(all.size() * windows_), queries_.clear();
    for (std::uint32_t k = 0; k < all.size(); ++k) queries_.push_back(place_balls(k));
    for (const AabbHit& hit : cull_.around(queries_, what_.filter)) {
        if (std::ranges::binary_search(own_, hit.body) || balls_[hit.query * windows_].radius < 0) continue;
        const std::uint32_t number = cull_.box_of(hit.body);
        const PlacedBox& box = cull_.box(number);
        const Eigen::Isometry3d to_box = box.pose.inverse(Eigen::Isometry);
        for (std::uint32_t w = 0; w < windows_; ++w) {
            const Window& ball = balls_[hit.query * windows_ + w];
            const Eigen::Vector3d seen = to_box * ball.centre - box.centre;
            const double within = ball.radius + cull_.rounding() * (seen.norm() + box.half.sum());
            if ((seen.cwiseAbs() - box.half).cwiseMax(0).squaredNorm() > within * within) continue;
            const double begin = double(w) / windows_, end = double(w + 1) / windows_;
            for (const std::uint32_t part : all[hit.query].parts)
                if (cull_.is_open(part, number, begin, end, ball.bent))
                    items.push_back({begin, end, part, no_part, cull_.body_at(hit.body), root, number});
        }
    }
}

/// Finds balls around the rigid parts in all windows, and the box around all. Negative radius: they do not move, so
/// both ends are tested.
Aabb EdgeSearch::place_balls(std::uint32_t number)
{
    const RigidParts& rigid = motion_.rigid()[number];
    const std::uint32_t parts = std::min(windows_, 4u), each = windows_ / parts;
    Window* window = &balls_[number * windows_];
    Aabb box;
    for (std::uint32_t part = 0; part < parts; ++part) {
        const EdgeItem item{double(part) / parts, double(part + 1) / parts, 0, no_part, {}, robot_.tree.root()};
        motion_.place(item.middle());
        const BallTravel way = motion_.travel(item, rigid.ball, rigid.link);
        const double bent = way.sagitta() / (double(each) * each) * robot_.stretch();
        for (std::uint32_t k = 0; k < each; ++k, ++window) {
            const double w = part * each + k;
            const auto centre = [&](double end) -> Eigen::Vector3d {
                return motion_.at(end / windows_).links[rigid.link] * rigid.ball.centre;
            };
            const Eigen::Vector3d begin = centre(w), end = centre(w + 1);
            const double radius = 0.5 * (end - begin).norm() + bent + rigid.ball.radius + clearances_.most_of_bodies();
            *window = {0.5 * (begin + end), way.moved == 0 ? -1 : radius, bent};
            const double reach = radius + 1e-12 * (radius + window->centre.norm());
            box.add(window->centre.array() - reach), box.add(window->centre.array() + reach);
        }
    }
    return box;
}

} // namespace oncollide
