// Robot::check(): many configurations, in chunks. In a chunk all configurations are tested pair by pair of parts, so
// that the World gets batches; a configuration leaves when a pair collides.
#include <oncollide/robots/robot_impl.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>

namespace oncollide {

SphereCull::SphereCull(const Robot::Impl& robot, double clearance)
    : robot_(robot), clearance_(clearance), stretch_(robot.stretch()), groups_(robot.groups.size()),
      spheres_(robot.spheres.size() + robot.parts.size()), placed_(robot.parts.size())
{
}

SphereCull::Placed SphereCull::placed(const CoverSphere& sphere, std::uint32_t link) const
{
    const Eigen::Vector3d at = links_[link] * sphere.centre;
    const double slack = 1e-12 * (links_[link].translation().cwiseAbs().sum() + sphere.centre.cwiseAbs().sum());
    return {at.x(), at.y(), at.z(), sphere.radius * stretch_ + slack};
}

void SphereCull::place(const Eigen::Isometry3d* links)
{
    links_ = links;
    std::ranges::fill(placed_, std::uint8_t{0});
    for (std::size_t i = 0; i < groups_.size(); ++i) groups_[i] = placed(robot_.groups[i].whole, robot_.groups[i].link);
}

const SphereCull::Placed* SphereCull::spheres_of(std::uint32_t i)
{
    const Robot::Impl::Part& part = robot_.parts[i];
    Placed* const first = &spheres_[part.cover.first + i];
    if (!placed_[i]) {
        first[0] = placed(part.cover.whole, part.link);
        for (std::uint32_t k = 0; k < part.cover.count; ++k)
            first[k + 1] = placed(robot_.spheres[part.cover.first + k], part.link);
        placed_[i] = 1;
    }
    return first;
}

bool SphereCull::meet(const Placed& a, const Placed& b, double reach) const
{
    const double dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
    const double within = (a.radius + b.radius + clearance_ + reach) * (1 + 1e-12);
    return dx * dx + dy * dy + dz * dz <= within * within;
}

bool SphereCull::near(std::uint32_t a, std::uint32_t b, double reach)
{
    const Placed *const of_a = spheres_of(a), *const of_b = spheres_of(b);
    if (!meet(of_a[0], of_b[0], reach)) return false;
    const std::uint32_t count_a = robot_.parts[a].cover.count, count_b = robot_.parts[b].cover.count;
    for (std::uint32_t i = 1; i <= count_a; ++i) {
        if (!meet(of_a[i], of_b[0], reach)) continue;
        for (std::uint32_t k = 1; k <= count_b; ++k)
            if (meet(of_a[i], of_b[k], reach)) return true;
    }
    return false;
}

namespace {

constexpr std::size_t chunk_size = 256;

/// Worse verdicts first.
int severity(Verdict verdict)
{
    return verdict == Verdict::colliding ? 3 : verdict == Verdict::undecided ? 2 : verdict == Verdict::within ? 1 : 0;
}

} // namespace

/// Tests chunks; one per thread.
class Robot::Checker {
public:
    Checker(const Robot::Impl& robot, const World& world, const RobotCheck& what)
        : robot_(robot), world_(world), what_(what), cull_(robot, world.settings().clearance), own_(robot.own_slots()),
          near_(robot.group_pairs.size())
    {
    }

    void run(std::span<const double> numbers, std::span<RobotFinding> findings)
    {
        findings_ = findings;
        const std::size_t links = robot_.description.links.size(), width = robot_.tree.width();
        poses_.resize(findings.size() * links, Eigen::Isometry3d::Identity());
        for (std::size_t i = 0; i < findings.size(); ++i) {
            robot_.tree.link_poses(numbers.data() + i * width, robot_.base, &poses_[i * links]);
            findings[i] = {};
            findings[i].bound = world_.settings().clearance;
        }
        if (what_.self) check_self();
        if (what_.environment && world_.size() > own_.size()) check_environment();
    }

private:
    const Eigen::Isometry3d* links(std::uint32_t i) const { return &poses_[i * robot_.description.links.size()]; }
    bool is_open(std::uint32_t i) const { return findings_[i].verdict != Verdict::colliding; }
    PlacedModel placed(std::uint32_t part, std::uint32_t i) const
    {
        return {robot_.parts[part].model, robot_.pose_of(robot_.parts[part], links(i))};
    }

    void take(std::uint32_t i, const Finding& found, std::uint32_t link, std::uint32_t other, BodyId body)
    {
        RobotFinding& worst = findings_[i];
        const int mine = severity(found.verdict), known = severity(worst.verdict);
        if (mine > known || (mine == known && mine > 0 && found.bound < worst.bound))
            worst = {found.bound, found.verdict, link, other, body};
    }

    /// In each configuration, the pairs of parts that bounding spheres cannot rule out.
    void find_near()
    {
        for (auto& list : near_) list.clear();
        for (std::uint32_t i = 0; i < findings_.size(); ++i) {
            cull_.place(links(i));
            for (std::size_t g = 0; g < near_.size(); ++g) {
                const Robot::Impl::GroupPair& groups = robot_.group_pairs[g];
                if (!cull_.groups_near(groups.a, groups.b)) continue;
                for (std::uint32_t p = groups.first; p < groups.end; ++p)
                    if (cull_.near(robot_.pairs[p].a, robot_.pairs[p].b)) near_[g].push_back({i, p});
            }
        }
    }

    void check_self()
    {
        find_near();
        for (const auto& list : near_) {
            pairs_.clear(), near_open_.clear();
            for (const Near& near : list)
                if (is_open(near.configuration)) {
                    const auto [a, b, seen_from] = robot_.pairs[near.pair];
                    pairs_.push_back({placed(a, near.configuration), placed(b, near.configuration)});
                    near_open_.push_back(near);
                }
            found_.resize(pairs_.size());
            if (!pairs_.empty()) world_.decide(pairs_, found_);
            for (std::size_t k = 0; k < near_open_.size(); ++k) {
                const auto [a, b, seen_from] = robot_.pairs[near_open_[k].pair];
                take(near_open_[k].configuration, found_[k], robot_.parts[a].link, robot_.parts[b].link, {});
            }
        }
    }

    /// Queries a model for the configurations in of_; calls take(configuration, hit) for each hit of another body.
    template <class Take>
    void query(ModelId model, std::uint32_t link, const Eigen::Isometry3d& pose, Take take)
    {
        queries_.clear();
        for (const std::uint32_t i : of_) queries_.push_back({model, links(i)[link] * pose, what_.filter});
        if (!of_.empty()) world_.query(queries_, hits_);
        for (std::size_t k = 0; k < of_.size(); ++k)
            for (std::size_t h = hits_.offsets[k]; h < hits_.offsets[k + 1]; ++h)
                if (const QueryHit& hit = hits_.hits[h]; !std::ranges::binary_search(own_, hit.body.slot))
                    take(of_[k], hit);
    }

    /// The last parts first: they reach farthest.
    void check_environment()
    {
        std::vector<std::uint32_t>& candidates = candidates_;
        for (std::size_t g = robot_.groups.size(); g-- > 0;) {
            const Robot::Impl::Group& group = robot_.groups[g];
            candidates.clear();
            for (std::uint32_t i = 0; i < findings_.size(); ++i)
                if (is_open(i)) candidates.push_back(i);
            if (group.model) { // is there anything around the group?
                of_.swap(candidates), candidates.clear();
                Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
                pose.translation() = group.whole.centre;
                query(group.model, group.link, pose, [&](std::uint32_t i, const QueryHit&) {
                    if (candidates.empty() || candidates.back() != i) candidates.push_back(i);
                });
            }
            for (std::uint32_t part = group.end; part-- > group.first;) {
                of_.clear();
                for (const std::uint32_t i : candidates)
                    if (is_open(i)) of_.push_back(i);
                query(robot_.parts[part].model, group.link, robot_.parts[part].pose,
                      [&](std::uint32_t i, const QueryHit& hit) {
                          take(i, hit, group.link, RobotFinding::no_link, hit.body);
                      });
            }
        }
    }

    /// A pair of parts that are near each other in a configuration.
    struct Near {
        std::uint32_t configuration, pair;
    };

    const Robot::Impl& robot_;
    const World& world_;
    const RobotCheck& what_;
    SphereCull cull_;
    std::vector<std::uint32_t> own_; ///< slots of the robot's bodies
    std::span<RobotFinding> findings_;
    std::vector<Eigen::Isometry3d> poses_;       ///< by configuration and link
    std::vector<std::vector<Near>> near_;        ///< by pair of groups
    std::vector<Near> near_open_;                ///< of a batch
    std::vector<std::uint32_t> of_, candidates_; ///< the configurations of a batch, and of a group
    std::vector<PairOfModels> pairs_;
    std::vector<Finding> found_;
    std::vector<ModelQuery> queries_;
    QueryHits hits_;
};

void Robot::check(const World& world, std::span<const double> configurations, std::span<RobotFinding> findings,
                  const RobotCheck& what) const
{
    const Impl& p = *impl_;
    p.check_world(world);
    p.check_numbers("check", "configuration", *this, configurations, findings.size());
    each_chunk(
        world, findings.size(), chunk_size, [&] { return std::make_unique<Checker>(p, world, what); },
        [&](Checker& checker, std::size_t first, std::size_t count) {
            checker.run(configurations.subspan(first * width(), count * width()), findings.subspan(first, count));
        });
}

} // namespace oncollide
