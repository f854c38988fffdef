#include <oncollide/robots/edges/edge_motion.hpp>

#include <algorithm>
#include <cmath>

namespace oncollide {

namespace {

constexpr int grid = 128;
constexpr std::size_t most_others = 8;

} // namespace

EdgeMotion::EdgeMotion(const Robot::Impl& robot)
    : robot_(robot), numbers_(robot.tree.width()), grid_(grid + 1), others_(most_others)
{
}

void EdgeMotion::start(const double* from, const double* to)
{
    from_ = from, to_ = to;
    for (auto* all : {&grid_, &others_})
        for (Placed& placed : *all) placed.share = -1;
    own_.share = -1;
    place(0.5);
    robot_.tree.rigid_links(from, to, highest_);
    rigid_.clear(), rigid_of_.clear();
    for (std::uint32_t i = 0; i < robot_.parts.size(); ++i) {
        const std::uint32_t link = highest_[robot_.parts[i].link];
        auto known = std::ranges::find(rigid_, link, &RigidParts::link);
        if (known == rigid_.end()) known = rigid_.insert(known, {link, {Eigen::Vector3d::Zero(), 0}, {}});
        known->parts.push_back(i);
        rigid_of_.push_back(static_cast<std::uint32_t>(known - rigid_.begin()));
    }
    for (RigidParts& rigid : rigid_) {
        balls_.clear();
        const Eigen::Isometry3d into = middle_->links[rigid.link].inverse(Eigen::Isometry);
        for (const std::uint32_t i : rigid.parts) {
            const CoverSphere& own = robot_.parts[i].cover.whole;
            const Eigen::Vector3d centre = into * (middle_->links[robot_.parts[i].link] * own.centre);
            const double arm = centre.norm(); // poses that are not quite rigid move the centre, too
            balls_.push_back({centre, (arm + own.radius) * robot_.stretch() - arm});
        }
        rigid.ball = around_spheres(balls_);
    }
}

bool EdgeMotion::is_on_grid(double share) const
{
    return grid * share == std::floor(grid * share);
}

const EdgeMotion::Placed& EdgeMotion::at(double share)
{
    if (is_on_grid(share)) {
        Placed& placed = grid_[static_cast<std::size_t>(grid * share)];
        place(placed, share);
        return placed;
    }
    const auto known = std::ranges::find(others_, share, &Placed::share);
    Placed& placed = known != others_.end() ? *known : others_[next_];
    if (&placed == &others_[next_]) next_ = (next_ + 1) % most_others;
    place(placed, share);
    return placed;
}

const Eigen::Isometry3d* EdgeMotion::place(double share)
{
    if (is_on_grid(share)) {
        middle_ = &at(share);
    } else {
        place(own_, share);
        middle_ = &own_;
    }
    return middle_->links.data();
}

void EdgeMotion::place(Placed& placed, double share)
{
    if (share == placed.share) return;
    placed.links.resize(robot_.description.links.size(), Eigen::Isometry3d::Identity());
    robot_.tree.between(from_, to_, share, numbers_.data());
    robot_.tree.link_poses(numbers_.data(), robot_.base, placed.links.data());
    placed.share = share;
}

BallTravel EdgeMotion::travel(const EdgeItem& item, const CoverSphere& ball, std::uint32_t link) const
{
    return robot_.tree.travel(from_, to_, 0.5 * (item.end - item.begin), middle_->links.data(), ball, link,
                              item.seen_from);
}

EdgeWays EdgeMotion::ways_of(const EdgeItem& item) const
{
    const auto way = [&](std::uint32_t part) {
        return travel(item, robot_.parts[part].cover.whole, robot_.parts[part].link);
    };
    return {way(item.a), item.b == no_part ? BallTravel{} : way(item.b)};
}

} // namespace oncollide
