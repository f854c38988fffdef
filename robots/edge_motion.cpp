#include <oncollide/robots/edge_motion.hpp>

#include <algorithm>

namespace oncollide {

EdgeMotion::EdgeMotion(const Robot::Impl& robot)
    : robot_(robot),
      numbers_(robot.tree.width()), middle_{-1, {robot.description.links.size(), Eigen::Isometry3d::Identity()}}
{
}

void EdgeMotion::start(const double* from, const double* to)
{
    from_ = from, to_ = to, middle_.share = -1;
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
        const Eigen::Isometry3d into = middle_.links[rigid.link].inverse(Eigen::Isometry);
        for (const std::uint32_t i : rigid.parts) {
            const CoverSphere& own = robot_.parts[i].cover.whole;
            const Eigen::Vector3d centre = into * (middle_.links[robot_.parts[i].link] * own.centre);
            const double arm = centre.norm(); // poses that are not quite rigid move the centre, too
            balls_.push_back({centre, (arm + own.radius) * robot_.stretch() - arm});
        }
        rigid.ball = around_spheres(balls_);
    }
}

const Eigen::Isometry3d* EdgeMotion::place(Placed& placed, double share)
{
    if (share != placed.share) {
        placed.links.resize(middle_.links.size(), Eigen::Isometry3d::Identity());
        robot_.tree.between(from_, to_, share, numbers_.data());
        robot_.tree.link_poses(numbers_.data(), robot_.base, placed.links.data());
        placed.share = share;
    }
    return placed.links.data();
}

BallTravel EdgeMotion::travel(const EdgeItem& item, const CoverSphere& ball, std::uint32_t link) const
{
    return robot_.tree.travel(from_, to_, 0.5 * (item.end - item.begin), middle_.links.data(), ball, link,
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
