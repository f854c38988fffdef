// Robot::check_edges(): the motion between two configurations, in windows of time that are halved where a pair may
// meet.
#include <oncollide/robots/robot_impl.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace oncollide {

namespace {

constexpr std::size_t edges_per_chunk = 16;
constexpr std::uint32_t most_windows = 64; // of a pair, to begin with
constexpr double most_turn = 0.25;         // rad: in windows of larger turns, motions are not tested, see Sweep

} // namespace

/// Tests edges one by one; one checker per thread.
class Robot::EdgeChecker {
public:
    EdgeChecker(const Robot::Impl& robot, const World& world, const RobotEdgeCheck& what)
        : robot_(robot), world_(world), what_(what), cull_(robot, world.settings().clearance), own_(robot.own_slots()),
          numbers_(robot.tree.width())
    {
        for (Placed* placed : {&begin_, &middle_, &end_})
            placed->links.resize(robot_.description.links.size(), Eigen::Isometry3d::Identity());
    }

    /// @param start, end  of check() at both ends
    void run(const double* from, const double* to, const RobotFinding& start, const RobotFinding& end,
             RobotEdgeFinding& found)
    {
        from_ = from, to_ = to, found_ = &found, tests_ = 0, open_.clear();
        found = {};
        if (take_end(0, start) || (take_end(1, end) && !what_.first)) return;
        begin();
        while (!items_.empty() && !is_done()) {
            if (tests_ > what_.most_tests) break;
            test();
        }
        finish();
    }

private:
    /// A pair of parts, or a part and a body, in a window of the edge.
    struct Item {
        double begin, end;
        std::uint32_t a, b; ///< parts; b of a body: no_part
        BodyId body;
        double middle() const { return 0.5 * (begin + end); }
    };
    /// The motion of both sides of an item in its window; of a body: at rest.
    struct Ways {
        BallTravel a, b;
        double turned() const { return a.turned + b.turned; }
        double reach(const Robot::Impl& robot) const { return (a.moved + b.moved) * robot.stretch(); }
    };
    static constexpr std::uint32_t no_part = 0xffffffffu;

    bool has_contact() const { return found_->contact_by <= 1; }

    /// Returns true if the configuration at an end of the edge is not separate.
    bool take_end(double share, const RobotFinding& at)
    {
        if (at.verdict == Verdict::separate) return false;
        *found_ = {0, share, at.verdict, at.link, at.other, at.body};
        return true;
    }

    /// The links at a share of the edge.
    struct Placed {
        double share = -1;
        std::vector<Eigen::Isometry3d> links;
    };
    const Eigen::Isometry3d* place(Placed& placed, double share)
    {
        if (share != placed.share) {
            robot_.tree.between(from_, to_, share, numbers_.data());
            robot_.tree.link_poses(numbers_.data(), robot_.base, placed.links.data());
            placed.share = share;
        }
        return placed.links.data();
    }
    std::uint32_t seen_from(const Item& item) const
    {
        if (item.b == no_part) return robot_.tree.root();
        return robot_.tree.common(robot_.parts[item.a].link, robot_.parts[item.b].link);
    }
    /// place(middle_, ...) comes first.
    Ways ways_of(const Item& item) const
    {
        const std::uint32_t from = seen_from(item);
        const auto way = [&](std::uint32_t part) {
            const Robot::Impl::Part& of = robot_.parts[part];
            return robot_.tree.travel(from_, to_, 0.5 * (item.end - item.begin), middle_.links.data(), of.cover.whole,
                                      of.link, from);
        };
        return {way(item.a), item.b == no_part ? BallTravel{} : way(item.b)};
    }
    /// The number of windows to begin with: fewer would be halved anyway.
    static std::uint32_t windows(double excess)
    {
        std::uint32_t count = 1;
        for (; count < most_windows && excess > 1; excess *= 0.5) count *= 2;
        return count;
    }
    template <class Take>
    static void each_window(std::uint32_t count, const Item& whole, Take take)
    {
        for (std::uint32_t k = 0; k < count; ++k) {
            Item item = whole;
            item.begin = k / static_cast<double>(count), item.end = (k + 1) / static_cast<double>(count);
            take(item);
        }
    }
    PlacedModel placed(std::uint32_t part) const
    {
        return {robot_.parts[part].model, robot_.pose_of(robot_.parts[part], middle_.links.data())};
    }

    /// Lists the pairs that bounding spheres and boxes cannot rule out, in the windows to begin with.
    void begin()
    {
        items_.clear();
        for (Placed* placed : {&begin_, &middle_, &end_}) placed->share = -1;
        if (what_.pairs.self) begin_self();
        if (what_.pairs.environment && world_.size() > own_.size()) begin_environment();
    }
    void begin_self()
    {
        cull_.place(place(middle_, 0.5));
        for (const auto& [a, b] : robot_.pairs) {
            const Item whole{0, 1, a, b, {}};
            const Ways ways = ways_of(whole);
            const double reach = ways.reach(robot_);
            if (reach == 0 || !cull_.near(a, b, reach)) continue;
            const double radius = std::min(robot_.parts[a].cover.whole.radius, robot_.parts[b].cover.whole.radius);
            each_window(windows(std::min(reach / radius, ways.turned() / most_turn)), whole,
                        [&](const Item& item) { items_.push_back(item); });
        }
    }
    void begin_environment()
    {
        tested_.clear(), queries_.clear(), reaches_.clear();
        place(middle_, 0.5);
        for (std::uint32_t part = 0; part < robot_.parts.size(); ++part) {
            const Item whole{0, 1, part, no_part, {}};
            const double reach = ways_of(whole).reach(robot_);
            if (reach == 0) continue; // both ends are tested
            each_window(windows(0.5 * reach / robot_.parts[part].cover.whole.radius), whole,
                        [&](const Item& item) { tested_.push_back(item); });
        }
        std::ranges::stable_sort(tested_, {}, &Item::middle);
        for (const Item& item : tested_) {
            const Robot::Impl::Part& part = robot_.parts[item.a];
            queries_.push_back({part.model, robot_.pose_of(part, place(middle_, item.middle())), what_.pairs.filter});
            reaches_.push_back(ways_of(item).reach(robot_));
        }
        world_.near(queries_, reaches_, hits_);
        tests_ += hits_.hits.size();
        for (std::size_t i = 0; i < tested_.size(); ++i)
            for (std::size_t h = hits_.offsets[i]; h < hits_.offsets[i + 1]; ++h)
                if (const BodyId body = hits_.hits[h].body; !std::ranges::binary_search(own_, body.slot)) {
                    tested_[i].body = body;
                    items_.push_back(tested_[i]);
                }
    }
    /// Tests all items, and replaces the ones that stay open by their halves.
    void test()
    {
        std::ranges::stable_sort(items_, {}, [](const Item& item) { return std::pair(item.middle(), item.a); });
        list_pairs();
        test_middles();
        test_places();
        test_motions();
        test_begins();
        items_.clear();
        for (Item item : tested_) {
            item.end = std::min(item.end, found_->contact_by);
            if (item.end <= item.begin) continue;
            if (item.end - item.begin <= what_.tolerance) {
                open_.push_back(item);
                continue;
            }
            Item second = item;
            item.end = second.begin = item.middle();
            items_.push_back(item), items_.push_back(second);
        }
    }
    /// One part and different bodies, in one window.
    static bool is_same_way(const Item& x, const Item& y)
    {
        return x.b == no_part && y.b == no_part && x.a == y.a && x.begin == y.begin && x.end == y.end;
    }
    /// Lists in tested_ the items before the first contact that bounding spheres do not decide.
    void list_pairs()
    {
        pairs_.clear(), reaches_.clear(), tested_.clear(), ways_.clear();
        double culled_at = -1;
        Item last{};
        Ways ways;
        for (const Item& item : items_) {
            if (item.begin >= found_->contact_by) continue;
            const Eigen::Isometry3d* const links = place(middle_, item.middle());
            if (!is_same_way(item, last)) ways = ways_of(item);
            last = item;
            const double reach = ways.reach(robot_);
            if (item.b == no_part) {
                pairs_.push_back({placed(item.a), {world_.model(item.body), world_.pose(item.body)}});
            } else {
                if (middle_.share != culled_at) cull_.place(links), culled_at = middle_.share;
                if (!cull_.near(item.a, item.b, reach)) continue;
                pairs_.push_back({placed(item.a), placed(item.b)});
            }
            reaches_.push_back(reach), tested_.push_back(item), ways_.push_back(ways);
        }
    }
    /// Looks for contacts in the middle of the windows: it takes less time than to show that there are none.
    void test_middles()
    {
        test_at([](const Item& item) { return item.middle(); });
        keep([&](std::size_t i) { return tested_[i].begin < found_->contact_by; });
    }
    /// Decides pairs_ at a share of each item.
    template <class Share>
    void test_at(Share share)
    {
        if (is_done() || pairs_.empty()) return;
        results_.resize(pairs_.size());
        world_.decide(pairs_, results_);
        tests_ += pairs_.size();
        for (std::size_t i = 0; i < pairs_.size(); ++i)
            if (results_[i].verdict != Verdict::separate)
                take_contact(tested_[i], share(tested_[i]), results_[i].verdict);
    }
    bool is_done() const { return !what_.first && has_contact(); }
    /// Leaves in tested_ the items whose pairs may meet, if they can be anywhere within the reach of the motion.
    void test_places()
    {
        if (is_done()) return;
        near_.resize(pairs_.size());
        world_.near(pairs_, reaches_, near_);
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
    /// Leaves in tested_ the items whose pairs may meet on their way: along rigid motions, and as far from these as
    /// joints that turn together bend the way.
    void test_motions()
    {
        if (is_done()) return;
        moving_.clear(), margins_.clear(), asked_.clear();
        for (std::uint32_t i = 0; i < tested_.size(); ++i) {
            const Item& item = tested_[i];
            if (ways_[i].turned() > most_turn) continue;
            asked_.push_back(i);
            if (item.begin == end_.share) std::swap(begin_, end_);
            place(begin_, item.begin), place(end_, item.end);
            const std::uint32_t from = seen_from(item);
            const double size = begin_.links[robot_.parts[item.a].link].translation().norm();
            double off = 0;
            const auto moving = [&](std::uint32_t part, const BallTravel& way) -> MovingModel {
                const Robot::Impl::Part& of = robot_.parts[part];
                const Eigen::Isometry3d first = seen(begin_, of, from), last = seen(end_, of, from);
                const double arm = (of.cover.whole.centre - of.pose.translation()).norm() + of.cover.whole.radius;
                off += way.off(arm);
                if (way.moved == 0) return {of.model, RigidMotion(first)};
                return {of.model, RigidMotion(first, last, way.helix ? MotionPath::screw : MotionPath::linear)};
            };
            MovingModel a = moving(item.a, ways_[i].a);
            if (item.b == no_part)
                moving_.push_back({std::move(a), {world_.model(item.body), RigidMotion(world_.pose(item.body))}});
            else
                moving_.push_back({std::move(a), moving(item.b, ways_[i].b)});
            margins_.push_back(std::min(off * robot_.stretch() + 1e-12 * size, 1e6));
        }
        until_.resize(moving_.size());
        world_.clear_until(moving_, margins_, until_);
        tests_ += moving_.size();
        clear_.assign(tested_.size(), 0);
        for (std::size_t k = 0; k < asked_.size(); ++k) {
            Item& item = tested_[asked_[k]];
            clear_[asked_[k]] = until_[k] >= 1;
            item.begin = std::min(item.begin + until_[k] * (item.end - item.begin) * (1 - 0x1p-50), item.end);
        }
        keep([&](std::size_t i) { return !clear_[i]; });
    }
    /// Looks for contacts soon after the windows' begin, to which motions have moved it.
    void test_begins()
    {
        if (is_done() || !what_.first) return;
        const auto soon = [&](const Item& item) { return std::min(item.begin + 0.5 * what_.tolerance, item.end); };
        for (std::size_t i = 0; i < tested_.size(); ++i) {
            place(middle_, soon(tested_[i]));
            pairs_[i].a = placed(tested_[i].a);
            if (tested_[i].b != no_part) pairs_[i].b = placed(tested_[i].b);
        }
        test_at(soon);
    }
    /// The pose of a part, seen from a link; from the root: in the world.
    Eigen::Isometry3d seen(const Placed& placed, const Robot::Impl::Part& part, std::uint32_t from) const
    {
        const Eigen::Isometry3d pose = robot_.pose_of(part, placed.links.data());
        return from == robot_.tree.root() ? pose : placed.links[from].inverse(Eigen::Isometry) * pose;
    }
    void take_contact(const Item& item, double share, Verdict verdict)
    {
        if (share >= found_->contact_by) return;
        const std::uint32_t other = item.b == no_part ? RobotFinding::no_link : robot_.parts[item.b].link;
        *found_ = {0, share, verdict, robot_.parts[item.a].link, other, item.body};
    }

    void finish()
    {
        const Item* first = nullptr;
        for (const auto* items : {&open_, &items_})
            for (const Item& item : *items)
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
    SphereCull cull_;
    std::vector<std::uint32_t> own_; ///< slots of the robot's bodies
    std::vector<double> numbers_;
    Placed begin_, middle_, end_; ///< of a window
    const double *from_ = nullptr, *to_ = nullptr;
    RobotEdgeFinding* found_ = nullptr;
    std::size_t tests_ = 0;
    std::vector<Item> items_, tested_, open_; ///< to test, not separate, too small to be halved
    std::vector<Ways> ways_;                  ///< of tested_, as are pairs_ and reaches_
    std::vector<PairOfModels> pairs_;
    std::vector<PairOfMovingModels> moving_;
    std::vector<ModelQuery> queries_;
    std::vector<double> reaches_, margins_, until_;
    std::vector<std::uint32_t> asked_;       ///< items whose motions are tested
    std::vector<std::uint8_t> near_, clear_; ///< by item
    std::vector<Finding> results_;
    QueryHits hits_;
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
    std::vector<RobotFinding> starts(findings.size()), ends(findings.size());
    check(world, from, starts, what.pairs), check(world, to, ends, what.pairs);
    each_chunk(
        world, findings.size(), edges_per_chunk, [&] { return std::make_unique<EdgeChecker>(p, world, what); },
        [&](EdgeChecker& checker, std::size_t first, std::size_t count) {
            for (std::size_t i = first; i < first + count; ++i)
                checker.run(&from[i * width()], &to[i * width()], starts[i], ends[i], findings[i]);
        });
}

} // namespace oncollide
