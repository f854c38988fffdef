// Robot::check(): many configurations, in chunks. In a chunk, bounding spheres find the pairs that are near each other,
// in all configurations at a time; the World decides these in batches. A configuration leaves when a pair collides.
#include <oncollide/robots/clearances.hpp>
#include <oncollide/robots/surroundings.hpp>

#include <algorithm>

#include <fmt/format.h>

namespace oncollide {

namespace {

constexpr std::size_t chunk_size = 128;
constexpr std::size_t batch_size = 64; // pairs

/// Worse verdicts first.
int severity(Verdict verdict)
{
    return verdict == Verdict::colliding ? 3 : verdict == Verdict::undecided ? 2 : verdict == Verdict::within ? 1 : 0;
}

} // namespace

/// Tests chunks of configurations; one checker per thread.
class Robot::Checker {
public:
    Checker(const Robot::Impl& robot, const World& world)
        : robot_(robot), clearances_(robot, world.settings().clearance), tests_(world),
          near_links_(robot.stretch(), clearances_.most_of_links()),
          near_bodies_(robot.stretch(), clearances_.most_of_bodies()), surroundings_(robot.covers, tests_),
          partings_(robot.group_pairs.size())
    {
        poses_of_batch_.reserve(2 * batch_size);
    }

    bool is_for(const World& world) const { return tests_.are_of(world); }
    /// Reads the World as it is now.
    /// @param copied  null: all bodies are where they are
    void begin(const World& world, const RobotCheck& what, const CopiedBodies* copied = nullptr)
    {
        tests_.begin();
        what_ = &what, is_exact_ = tests_.is_exact();
        models_.clear();
        for (const Robot::Impl::Part& part : robot_.parts) models_.push_back(&tests_.model(part.model));
        const std::vector<std::uint32_t> own = robot_.own_slots(world);
        has_surroundings_ = world.bodies().size() > own.size();
        surroundings_.begin(what.filter, own, copied);
    }

    /// @param number  the number of the first configuration
    void run(std::span<const double> numbers, std::size_t number, std::span<RobotFinding> findings)
    {
        const std::size_t links = robot_.description.links.size(), width = robot_.tree.width();
        findings_ = findings;
        batch_.clear(), near_pairs_.clear(), runs_.clear(); // an error may have ended the last call
        poses_.resize(findings.size() * links, Eigen::Isometry3d::Identity());
        open_.assign((findings.size() + 7) / 8, 0);
        for (std::size_t i = 0; i < findings.size(); ++i) {
            robot_.tree.link_poses(numbers.data() + i * width, robot_.base, &poses_[i * links]);
            if (!robot_.has_sound_poses) robot_.check_poses(&poses_[i * links], number + i);
            findings[i] = {};
            findings[i].bound = clearances_.of_world();
            open_[i / 8] |= static_cast<std::uint8_t>(1u << i % 8);
        }
        centres_.place(robot_.covers, poses_, links);
        if (what_->self) check_self();
        if (what_->environment && has_surroundings_) check_environment(number);
    }

private:
    /// A pair of parts, or of a part and a body, in a configuration. Pairs of a configuration are decided by ascending
    /// `order`. It holds the parts a and b, from the upper bits on, or the complement of the part and the body's slot.
    struct Near {
        std::uint32_t configuration;
        bool meets; ///< certainly
        std::uint64_t order;

        std::uint32_t upper() const { return static_cast<std::uint32_t>(order >> 32); }
        std::uint32_t lower() const { return static_cast<std::uint32_t>(order); }
    };
    /// The pairs of a configuration in near_pairs_ that are not in the batch yet: a heap.
    struct Run {
        std::size_t first, end;
    };

    const Eigen::Isometry3d& link(std::uint32_t configuration, std::uint32_t number) const
    {
        return poses_[configuration * robot_.description.links.size() + number];
    }
    Eigen::Isometry3d pose_of(std::uint32_t part, std::uint32_t configuration) const
    {
        return robot_.pose_of(robot_.parts[part], &link(configuration, 0));
    }
    bool is_open(std::uint32_t i) const { return open_[i / 8] >> i % 8 & 1; }

    void check_self()
    {
        in_self_ = true;
        bits_.resize(open_.size());
        for (std::size_t p = 0; p < robot_.group_pairs.size(); ++p) {
            const Robot::Impl::GroupPair& pair = robot_.group_pairs[p];
            const GroupCover &a = robot_.covers[pair.a], &b = robot_.covers[pair.b];
            const float reach = near_links_.reach(a, b, centres_.sizes[pair.a] + centres_.sizes[pair.b]);
            ball_kernel().points_near(centres_.of(pair.a), centres_.of(pair.b), centres_.stride, reach, bits_.data());
            for (std::size_t k = 0; k < open_.size(); ++k) bits_[k] &= open_[k];
            each_bit(bits_, [&](std::uint32_t i) { add_parts(i, a, b, partings_[p]); });
            decide_runs();
        }
        decide_batch();
    }

    void add_parts(std::uint32_t i, const GroupCover& a, const GroupCover& b, Parting& parting)
    {
        const double clearance = clearances_.of_links(a.link(), b.link());
        const auto are_apart = [&](std::uint64_t pair) {
            const auto of_a = static_cast<std::uint32_t>(pair >> 32), of_b = static_cast<std::uint32_t>(pair);
            const PartSolids *const x = robot_.parts[of_a].solids.get(), *const y = robot_.parts[of_b].solids.get();
            return x && y && surely_apart(*x, pose_of(of_a, i), *y, pose_of(of_b, i), clearance, parting);
        };
        const bool single = a.has_one_part() && b.has_one_part();
        const bool known = single && parting.held(); // the direction then takes less time than the spheres
        if (known && are_apart(std::uint64_t{a.part(0)} << 32 | b.part(0))) return;
        pairs_.clear();
        near_links_.find(a, link(i, a.link()), b, link(i, b.link()), pairs_);
        // The list may hold the same pair several times.
        if (!single && !pairs_.empty() && robot_.parts[a.part(0)].solids) {
            std::ranges::sort(pairs_);
            pairs_.erase(std::ranges::unique(pairs_).begin(), pairs_.end());
        }
        const std::size_t first = near_pairs_.size();
        for (const std::uint64_t pair : pairs_)
            if (known || !are_apart(pair)) near_pairs_.push_back({i, false, pair});
        if (near_pairs_.size() > first) runs_.push_back({first, near_pairs_.size()});
    }

    /// Tests the last groups first, because they reach farthest.
    void check_environment(std::size_t number)
    {
        in_self_ = false;
        surroundings_.prepare(centres_, near_bodies_, number);
        for (auto g = static_cast<std::uint32_t>(robot_.covers.size()); g-- > 0;) {
            const std::span<const Surroundings::Near> all = surroundings_.find(g, open_);
            for (std::size_t k = 0; k < all.size();) {
                const std::uint32_t i = all[k].configuration;
                const std::size_t first = near_pairs_.size();
                for (; k < all.size() && all[k].configuration == i; ++k)
                    add_body(i, robot_.covers[g], surroundings_.body(all[k]));
                if (near_pairs_.size() > first) runs_.push_back({first, near_pairs_.size()});
            }
            decide_runs();
            decide_batch(); // most contacts are found here: later groups need not be tested
        }
    }

    void add_body(std::uint32_t i, const GroupCover& group, const PlacedBody& body)
    {
        const BodyId id = tests_.body_at(body.slot);
        if (robot_.allows(group.link(), id)) return;
        const double clearance = clearances_.of_body(group.link(), id);
        parts_.clear();
        near_bodies_.find(group, link(i, group.link()), body.box, parts_);
        for (const std::uint32_t part : parts_) {
            const PartSolids* const solids = robot_.parts[part].solids.get();
            Near near{i, false, std::uint64_t{~part} << 32 | body.slot};
            if (solids) {
                if (!near_pairs_.empty() && near_pairs_.back().order == near.order &&
                    near_pairs_.back().configuration == i)
                    continue; // another sphere of the same part
                const Eigen::Isometry3d pose = pose_of(part, i);
                if (surely_apart(*solids, pose, body.box, clearance)) continue;
                near.meets = is_exact_ && surely_meet(*solids, pose, body);
            }
            near_pairs_.push_back(near);
        }
    }

    /// Moves the first pair of each run to the batch, then the second pair of each run whose configuration is still
    /// open, and so on.
    void decide_runs()
    {
        const auto later = [](const Near& a, const Near& b) { return a.order > b.order; };
        for (const Run& run : runs_)
            if (run.end - run.first > 1) std::ranges::make_heap(of(run), later);
        for (bool is_first = true; !runs_.empty(); is_first = false) {
            if (!is_first) decide_batch();
            std::size_t left = 0;
            for (Run run : runs_) {
                const Near next = near_pairs_[run.first];
                if (!is_open(next.configuration)) continue;
                batch_.push_back(next);
                if (batch_.size() == batch_size) decide_batch();
                do { // a part may be listed more than once
                    std::ranges::pop_heap(of(run), later), --run.end;
                } while (run.end > run.first && near_pairs_[run.first].order == next.order);
                if (run.end > run.first) runs_[left++] = run;
            }
            runs_.resize(left);
        }
        near_pairs_.clear();
    }
    std::span<Near> of(const Run& run) { return std::span(near_pairs_).subspan(run.first, run.end - run.first); }

    void decide_batch()
    {
        tasks_.clear(), poses_of_batch_.clear();
        for (const Near& near : batch_) {
            if (near.meets) continue;
            const auto placed = [&](std::uint32_t part) {
                poses_of_batch_.push_back(pose_of(part, near.configuration));
                return &poses_of_batch_.back();
            };
            const std::uint32_t a = in_self_ ? near.upper() : ~near.upper(), b = near.lower();
            PairTask task{static_cast<std::uint32_t>(tasks_.size()), models_[a], nullptr, placed(a), nullptr};
            if (in_self_)
                task.b = models_[b], task.pose_b = placed(b);
            else
                task.b = &tests_.model_at(b), task.pose_b = &surroundings_.pose_at(b, near.configuration);
            tasks_.push_back(task);
        }
        const Finding* found = tasks_.empty() ? nullptr : tests_.decide(tasks_).data();
        const PairTask* task = tasks_.data();
        for (const Near& near : batch_) {
            Finding finding{Verdict::colliding, ContactKind::unknown, 0};
            if (!near.meets) {
                finding = *found++;
                if (clearances_.padded() && finding.verdict == Verdict::separate && is_open(near.configuration))
                    finding = tests_.within(*task, clearance_of(near));
                ++task;
            }
            take(near, finding);
        }
        batch_.clear();
    }
    double clearance_of(const Near& near) const
    {
        if (in_self_) return clearances_.of_links(robot_.parts[near.upper()].link, robot_.parts[near.lower()].link);
        return clearances_.of_body(robot_.parts[~near.upper()].link, tests_.body_at(near.lower()));
    }

    void take(const Near& near, const Finding& found)
    {
        RobotFinding& worst = findings_[near.configuration];
        const int mine = severity(found.verdict), known = severity(worst.verdict);
        if (mine < known || mine == 0 || (mine == known && found.bound >= worst.bound)) return;
        worst.bound = found.bound, worst.verdict = found.verdict;
        worst.link = robot_.parts[in_self_ ? near.upper() : ~near.upper()].link;
        worst.other = in_self_ ? robot_.parts[near.lower()].link : RobotFinding::no_link;
        worst.body = in_self_ ? BodyId{} : tests_.body_at(near.lower());
        if (found.verdict == Verdict::colliding || clearances_.padded())
            open_[near.configuration / 8] &= static_cast<std::uint8_t>(~(1u << near.configuration % 8));
    }

    const Robot::Impl& robot_;
    const Clearances clearances_;
    WorldAccess::PlacedTests tests_;
    NearParts near_links_, near_bodies_;
    Surroundings surroundings_;
    std::vector<Parting> partings_; ///< by pair of groups
    const RobotCheck* what_ = nullptr;
    bool is_exact_ = false, has_surroundings_ = false, in_self_ = true;
    std::vector<Model*> models_; ///< by part
    std::span<RobotFinding> findings_;
    std::vector<Eigen::Isometry3d> poses_; ///< by configuration and link
    GroupCentres centres_;
    std::vector<std::uint8_t> open_, bits_; ///< bits of configurations; open: no pair is known to collide
    std::vector<std::uint64_t> pairs_;
    std::vector<std::uint32_t> parts_;
    std::vector<Near> near_pairs_, batch_;
    std::vector<Run> runs_;
    std::vector<PairTask> tasks_;
    std::vector<Eigen::Isometry3d> poses_of_batch_;
};

/// Checkers of earlier calls.
struct Robot::Impl::IdleCheckers : IdleCheckersOf<Checker> {};

std::shared_ptr<Robot::Impl::IdleCheckers> Robot::Impl::no_checkers()
{
    return std::make_shared<IdleCheckers>();
}

void Robot::check(const World& world, std::span<const double> configurations, std::span<RobotFinding> findings,
                  const RobotCheck& what) const
{
    check(world, WorldCopies{}, configurations, findings, what);
}

void Robot::check(const World& world, const WorldCopies& copies, std::span<const double> configurations,
                  std::span<RobotFinding> findings, const RobotCheck& what) const
{
    const Impl& p = *impl_;
    p.check_world(world);
    p.check_numbers("check", "configuration", *this, configurations, findings.size());
    const CopiedBodies copied(world, copies, findings.size());
    for (const std::uint32_t slot : p.own_slots(world))
        if (std::ranges::binary_search(copied.sorted(), slot))
            throw Error(ErrorKind::usage, "robot: check: a body of the copies is the robot's own");
    each_chunk(
        world, findings.size(), chunk_size,
        [&] { return p.idle->lease(p, world, what, copied.size() ? &copied : nullptr); },
        [&](Checker& checker, std::size_t first, std::size_t count) {
            checker.run(configurations.subspan(first * width(), count * width()), first,
                        findings.subspan(first, count));
        });
}

} // namespace oncollide
