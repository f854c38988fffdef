// Robot::check_edges(): the motion between two configurations, in windows of time that are halved where a pair may
// meet.
#include <oncollide/robots/edges/edge_search.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {

namespace {

constexpr std::size_t edges_per_chunk = 16;
constexpr int samples = 8;        // parts of an edge
constexpr double most_turn = 0.3; // rad: in windows of larger turns, motions are not tested, see Sweep

} // namespace

/// Tests edges one by one; one checker per thread.
class Robot::EdgeChecker {
public:
    EdgeChecker(const Robot::Impl& robot, const World& world, const RobotEdgeCheck& what)
        : robot_(robot), world_(world), what_(what), clearances_(robot, world.settings().clearance),
          cull_(robot, clearances_.most_of_links()), own_(robot.own_slots(world)), motion_(robot),
          solids_(robot, world, clearances_, motion_),
          search_(robot, world, what.pairs, clearances_, motion_, solids_, own_)
    {
    }

    /// @param found  receives the contact, if one is known
    void run(const double* from, const double* to, RobotEdgeFinding& found)
    {
        found_ = &found, open_.clear(), items_.clear();
        motion_.start(from, to);
        solids_.start();
        search_.run(items_);
        tests_ = items_.size(), is_searched_ = true;
        while (!items_.empty() && !is_done()) {
            if (tests_ > what_.most_tests) break;
            test();
        }
        finish();
    }

private:
    bool has_contact() const { return found_->contact_by <= 1; }

    PlacedModel placed(std::uint32_t part) const
    {
        return {robot_.parts[part].model, robot_.pose_of(robot_.parts[part], motion_.middle().links.data())};
    }

    /// Tests all items, and replaces the ones that stay open by their halves.
    void test()
    {
        std::ranges::stable_sort(items_, {}, [](const EdgeItem& item) { return std::pair(item.middle(), item.a); });
        list_pairs();
        test_middles();
        test_places();
        test_motions();
        test_begins();
        items_.clear(), is_searched_ = false;
        for (EdgeItem item : tested_) {
            item.end = std::min(item.end, found_->contact_by);
            if (item.end <= item.begin) continue;
            // test_begins() also tests the time just after the item.
            if (item.end - item.begin <= 0.5 * what_.tolerance) {
                open_.push_back(item);
                continue;
            }
            EdgeItem second = item;
            item.end = second.begin = item.middle();
            items_.push_back(item), items_.push_back(second);
        }
    }
    /// True if both items have one part, different bodies and one window.
    static bool is_same_way(const EdgeItem& x, const EdgeItem& y)
    {
        return x.b == no_part && y.b == no_part && x.a == y.a && x.begin == y.begin && x.end == y.end;
    }
    /// Lists in tested_ the items before the first contact that bounding spheres do not decide.
    void list_pairs()
    {
        pairs_.clear(), reaches_.clear(), tested_.clear(), ways_.clear();
        double culled_at = -1;
        EdgeItem last{};
        EdgeWays ways;
        for (const EdgeItem& item : items_) {
            if (item.begin >= found_->contact_by) continue;
            const Eigen::Isometry3d* const links = motion_.place(item.middle());
            if (!is_same_way(item, last)) ways = motion_.ways_of(item);
            last = item;
            const double reach = motion_.reach(ways);
            if (item.b == no_part) {
                if (!is_searched_ && !solids_.is_open(item, ways)) continue;
                pairs_.push_back({placed(item.a), {world_.bodies().model(item.body), world_.bodies().pose(item.body)}});
            } else {
                if (motion_.middle().share != culled_at) cull_.place(links), culled_at = motion_.middle().share;
                if (!cull_.near(item.a, item.b, reach) || !solids_.is_open(item, ways)) continue;
                pairs_.push_back({placed(item.a), placed(item.b)});
            }
            reaches_.push_back(reach + more(item)), tested_.push_back(item), ways_.push_back(ways);
        }
    }
    /// Looks for contacts in the middle of the windows: finding one takes less time than showing that there is none.
    void test_middles()
    {
        test_at([](const EdgeItem& item) { return item.middle(); });
        keep([&](std::size_t i) { return tested_[i].begin < found_->contact_by; });
    }
    /// Decides pairs_ at a share of each item.
    template <class Share>
    void test_at(Share share)
    {
        if (is_done() || pairs_.empty()) return;
        results_.resize(pairs_.size());
        world_.pairs().decide(pairs_, results_);
        tests_ += pairs_.size();
        for (std::size_t i = 0; i < pairs_.size(); ++i)
            if (const Verdict verdict = padded(i, results_[i].verdict); verdict != Verdict::separate)
                take_contact(tested_[i], share(tested_[i]), verdict);
    }
    /// The clearance of an item's pair minus the World's.
    double more(const EdgeItem& item) const
    {
        const std::uint32_t link = robot_.parts[item.a].link;
        const double all = item.b == no_part ? clearances_.of_body(link, item.body)
                                             : clearances_.of_links(link, robot_.parts[item.b].link);
        return all - clearances_.of_world();
    }
    /// The verdict of pairs_[i], which the World decided, with its clearance.
    Verdict padded(std::size_t i, Verdict verdict)
    {
        if (!clearances_.padded() || verdict != Verdict::separate) return verdict;
        return solids_.within(pairs_[i], clearances_.of_world() + more(tested_[i])) ? Verdict::within : verdict;
    }
    bool is_done() const { return !what_.first && has_contact(); }
    /// Leaves in tested_ the items whose pairs may meet, if they can be anywhere within the reach of the motion.
    void test_places()
    {
        if (is_done()) return;
        near_.resize(pairs_.size());
        WorldAccess::near(world_, pairs_, reaches_, near_);
        tests_ += pairs_.size();
        keep([&](std::size_t i) { return near_[i] != 0; });
    }
    /// Removes items, and their pairs.
    template <class Keep>
    void keep(Keep open)
    {
        std::size_t left = 0;
        for (std::size_t i = 0; i < tested_.size(); ++i)
            if (open(i)) {
                tested_[left] = tested_[i], ways_[left] = ways_[i];
                reaches_[left] = reaches_[i], pairs_[left] = pairs_[i];
                ++left;
            }
        tested_.resize(left), ways_.resize(left), reaches_.resize(left), pairs_.resize(left);
    }
    /// Leaves in tested_ the items whose pairs may meet on their way: along rigid motions, widened by how far joints
    /// that turn together bend the way.
    void test_motions()
    {
        if (is_done()) return;
        moving_.clear(), margins_.clear(), asked_.clear();
        for (std::uint32_t i = 0; i < tested_.size(); ++i) {
            const EdgeItem& item = tested_[i];
            if (ways_[i].turned() > most_turn) continue;
            asked_.push_back(i);
            const EdgeMotion::Placed &begin = motion_.at(item.begin), &end = motion_.at(item.end);
            const std::uint32_t from = item.seen_from;
            const double size = begin.links[robot_.parts[item.a].link].translation().norm();
            double off = 0;
            const auto moving = [&](std::uint32_t part, const BallTravel& way) -> MovingModel {
                const Robot::Impl::Part& of = robot_.parts[part];
                const Eigen::Isometry3d first = seen(begin, of, from), last = seen(end, of, from);
                const double arm = (of.cover.whole.centre - of.pose.translation()).norm() + of.cover.whole.radius;
                off += way.off(arm);
                if (way.moved == 0) return {of.model, RigidMotion(first)};
                return {of.model, RigidMotion(first, last, way.helix ? MotionPath::screw : MotionPath::linear)};
            };
            MovingModel a = moving(item.a, ways_[i].a);
            if (item.b == no_part)
                moving_.push_back(
                    {std::move(a), {world_.bodies().model(item.body), RigidMotion(world_.bodies().pose(item.body))}});
            else
                moving_.push_back({std::move(a), moving(item.b, ways_[i].b)});
            margins_.push_back(std::min(off * robot_.stretch() + 1e-12 * size, 1e6) + more(item));
        }
        until_.resize(moving_.size());
        WorldAccess::clear_until(world_, moving_, margins_, until_);
        tests_ += moving_.size();
        clear_.assign(tested_.size(), 0);
        for (std::size_t k = 0; k < asked_.size(); ++k) {
            EdgeItem& item = tested_[asked_[k]];
            clear_[asked_[k]] = until_[k] >= 1;
            item.begin = std::min(item.begin + until_[k] * (item.end - item.begin) * (1 - 0x1p-50), item.end);
        }
        keep([&](std::size_t i) { return !clear_[i]; });
    }
    /// Looks for contacts soon after the beginning of each window, which the tests of motions have moved.
    void test_begins()
    {
        if (is_done() || !what_.first) return;
        const auto soon = [&](const EdgeItem& item) { return std::min(item.begin + 0.5 * what_.tolerance, item.end); };
        for (std::size_t i = 0; i < tested_.size(); ++i) {
            motion_.place(soon(tested_[i]));
            pairs_[i].a = placed(tested_[i].a);
            if (tested_[i].b != no_part) pairs_[i].b = placed(tested_[i].b);
        }
        test_at(soon);
    }
    /// The pose of a part, seen from a link; seen from the root, it is the pose in the world.
    Eigen::Isometry3d seen(const EdgeMotion::Placed& placed, const Robot::Impl::Part& part, std::uint32_t from) const
    {
        const Eigen::Isometry3d pose = robot_.pose_of(part, placed.links.data());
        return from == robot_.tree.root() ? pose : placed.links[from].inverse(Eigen::Isometry) * pose;
    }
    void take_contact(const EdgeItem& item, double share, Verdict verdict)
    {
        if (share >= found_->contact_by) return;
        const std::uint32_t other = item.b == no_part ? RobotFinding::no_link : robot_.parts[item.b].link;
        *found_ = {0, share, verdict, robot_.parts[item.a].link, other, item.body};
    }

    void finish()
    {
        const EdgeItem* first = nullptr;
        for (const auto* items : {&open_, &items_})
            for (const EdgeItem& item : *items)
                if (item.begin < found_->contact_by && (!first || item.begin < first->begin)) first = &item;
        found_->clear_until = std::min({1.0, first ? first->begin : 1.0, found_->contact_by});
        if (has_contact()) return;
        found_->verdict = first ? Verdict::undecided : Verdict::separate;
        if (!first) return;
        found_->link = robot_.parts[first->a].link, found_->body = first->body;
        if (first->b != no_part) found_->other = robot_.parts[first->b].link;
    }

    const Robot::Impl& robot_;
    const World& world_;
    const RobotEdgeCheck& what_;
    const Clearances clearances_;
    SphereCull cull_;
    std::vector<std::uint32_t> own_; ///< slots of the robot's bodies
    EdgeMotion motion_;
    EdgeCull solids_;
    EdgeSearch search_;
    bool is_searched_ = false; ///< items_ come from search_
    RobotEdgeFinding* found_ = nullptr;
    std::size_t tests_ = 0;
    std::vector<EdgeItem> items_, tested_, open_; ///< items to test; items that are not separate; items too small to be
                                                  ///< halved
    std::vector<EdgeWays> ways_;                  ///< the ways of tested_, as are pairs_ and reaches_
    std::vector<PairOfModels> pairs_;
    std::vector<PairOf<MovingModel>> moving_;
    std::vector<double> reaches_, margins_, until_;
    std::vector<std::uint32_t> asked_;       ///< items whose motions are tested
    std::vector<std::uint8_t> near_, clear_; ///< by item
    std::vector<Finding> results_;
};

void Robot::check_edges(const World& world, std::span<const double> from, std::span<const double> to,
                        std::span<RobotEdgeFinding> findings, const RobotEdgeCheck& what) const
{
    const Impl& p = *impl_;
    p.check_world(world);
    p.check_numbers("check_edges", "start", *this, from, findings.size());
    p.check_numbers("check_edges", "end", *this, to, findings.size());
    if (!(what.tolerance >= 1e-9 && what.tolerance <= 1))
        throw Error(ErrorKind::usage,
                    fmt::format("robot: check_edges: tolerance {}: must be 1e-9 to 1", what.tolerance));
    std::vector<std::uint32_t> open(findings.size());
    std::iota(open.begin(), open.end(), 0u);
    std::ranges::fill(findings, RobotEdgeFinding());
    std::vector<double> numbers;
    std::vector<RobotFinding> found;
    // Samples find most contacts, at a fraction of the cost of a bound: both ends, the middle, the quarters and so on.
    const auto sample = [&](std::span<const double> shares) {
        numbers.resize(open.size() * shares.size() * width()), found.resize(open.size() * shares.size());
        double* at = numbers.data();
        for (const std::uint32_t i : open)
            for (const double share : shares) {
                p.tree.between(&from[i * width()], &to[i * width()], share, at);
                at += width();
            }
        check(world, numbers, found, what.pairs);
        std::erase_if(open, [&, k = std::size_t{0}](std::uint32_t i) mutable {
            for (const double share : shares)
                if (const RobotFinding& there = found[k++];
                    there.verdict != Verdict::separate && share < findings[i].contact_by)
                    findings[i] = {0, share, there.verdict, there.link, there.other, there.body};
            return what.first ? findings[i].contact_by == 0 : findings[i].contact_by <= 1;
        });
    };
    sample(std::array{0.0, 1.0});
    for (int of = 2; of <= samples && !open.empty(); of *= 2) {
        std::vector<double> shares;
        for (int k = 1; k < of; k += 2) shares.push_back(static_cast<double>(k) / of);
        sample(shares);
    }
    each_chunk(
        world, open.size(), edges_per_chunk, [&] { return std::make_unique<EdgeChecker>(p, world, what); },
        [&](EdgeChecker& checker, std::size_t first, std::size_t count) {
            for (const std::uint32_t i : std::span(open).subspan(first, count))
                checker.run(&from[i * width()], &to[i * width()], findings[i]);
        });
}

} // namespace oncollide
