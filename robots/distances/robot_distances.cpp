// Robot::distances(): per configuration, the pairs by their lower bounds, from balls around groups, then around parts;
// the nearest are measured until no other can be nearer.
#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/robots/robot_impl.hpp>

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include <oncollide/narrowphase/model.hpp>
#include <oncollide/pipeline/world/placed_tests.hpp>
#include <oncollide/robots/distances/nearest_features.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

constexpr std::size_t configurations_per_chunk = 16; // configurations; a chunk does not depend on the number of threads
constexpr std::size_t most_listed = 256;             // bodies: with more, the broad phase finds the near ones

void check_options(const RobotDistanceOptions& options)
{
    for (const auto& [what, value] : {std::pair("tolerance", options.tolerance), std::pair("cutoff", options.cutoff)})
        if (!(value >= 0))
            throw Error(ErrorKind::usage, fmt::format("robot: distances: a {} of {}; must be 0 or more", what, value));
}

} // namespace

/// Measures configurations, one after another; one finder per thread.
class Robot::DistanceFinder {
public:
    DistanceFinder(const Robot::Impl& robot, const World& world) : robot_(robot), tests_(world), cull_(robot, 0) {}

    bool is_for(const World& world) const { return tests_.are_of(world); }
    /// Reads the World as it is now.
    void begin(const World& world, const RobotDistanceOptions& options)
    {
        tests_.begin();
        options_ = options;
        models_.clear();
        for (const Robot::Impl::Part& part : robot_.parts) models_.push_back(&tests_.model(part.model));
        own_ = robot_.own_slots(world);
        bodies_.clear();
        in_reach_ = false;
        if (!options.pairs.environment || world.bodies().size() <= own_.size()) return;
        in_reach_ = world.bodies().size() > most_listed + own_.size();
        if (!in_reach_) list_bodies(half_space_end);
    }

    /// Appends the pairs of each configuration.
    /// @param number  the number of the first configuration
    void run(std::span<const double> numbers, std::size_t number, std::size_t count, RobotDistances& found)
    {
        const std::size_t width = robot_.tree.width();
        poses_.resize(robot_.description.links.size(), Eigen::Isometry3d::Identity());
        has_hint_ = false;
        for (std::size_t i = 0; i < count; ++i) {
            const double* const own = numbers.data() + i * width;
            robot_.tree.link_poses(own, robot_.base, poses_.data());
            if (!robot_.has_sound_poses) robot_.check_poses(poses_.data(), number + i);
            cull_.place(poses_.data());
            options_.every_pair ? find_every() : find_least();
            for (const Measured& m : measured_) add(own, m.distance, found);
            found.offsets.push_back(found.pairs.size());
        }
    }

private:
    enum class Stage : std::uint8_t { groups, parts, group_and_body, part_and_body };
    /// A pair that may be as near as `lower`. For groups, `b` is the number of their pair.
    struct Candidate {
        double lower = 0;
        Stage stage = Stage::groups;
        std::uint32_t a = 0, b = 0;

        auto order() const { return std::tuple(lower, stage, a, b); }
        bool same(const Candidate& other) const { return stage == other.stage && a == other.a && b == other.b; }
    };
    struct Measured {
        Candidate candidate;
        RobotDistance distance;
    };
    struct Body {
        std::uint32_t slot;
        Aabb box;
        PlacedBox own_box;
    };

    /// Lists the bodies within reach of a group; nothing is beyond half_space_end.
    void list_bodies(double reach)
    {
        bodies_.clear();
        Aabb where{Vector3d::Constant(-2 * half_space_end), Vector3d::Constant(2 * half_space_end)};
        if (reach < half_space_end) {
            where = {};
            for (std::uint32_t g = 0; g < robot_.groups.size(); ++g) where.add(cull_.box_of_group(g));
            where.min.array() -= reach, where.max.array() += reach;
        }
        for (const AabbHit& hit : tests_.around({&where, 1}, options_.pairs.filter)) {
            if (std::ranges::binary_search(own_, hit.body)) continue;
            Model& model = tests_.model_at(hit.body);
            const Eigen::Isometry3d& pose = tests_.pose_at(hit.body);
            bodies_.push_back({hit.body, model.bounds().box(pose),
                               PlacedBox(model.bounds().box(Eigen::Isometry3d::Identity()), pose)});
        }
    }

    /// Pairs beyond it do not count.
    double limit() const
    {
        if (options_.every_pair || measured_.empty()) return options_.cutoff;
        return std::min(options_.cutoff, std::max(measured_.front().distance.upper, 0.0));
    }
    bool is_done() const
    {
        return !options_.depths && !options_.every_pair && !measured_.empty() && measured_.front().distance.upper <= 0;
    }
    void push(const Candidate& c)
    {
        if (c.lower > limit()) return;
        open_.push_back(c);
        std::ranges::push_heap(open_, std::greater{}, &Candidate::order);
    }

    void push_self()
    {
        if (!options_.pairs.self) return;
        for (std::uint32_t p = 0; p < robot_.group_pairs.size(); ++p) {
            const Robot::Impl::GroupPair& pair = robot_.group_pairs[p];
            push({cull_.gap_of_groups(pair.a, pair.b), Stage::groups, pair.a, p});
        }
    }
    void push_bodies()
    {
        for (std::uint32_t b = 0; b < bodies_.size(); ++b)
            for (std::uint32_t g = 0; g < robot_.groups.size(); ++g)
                push({cull_.gap_of_group(g, bodies_[b].box), Stage::group_and_body, g, b});
    }

    void find_least()
    {
        measured_.clear();
        const Candidate hint = hint_;
        if (has_hint_) measure(hint); // nearly the limit
        push_self();
        if (!in_reach_) push_bodies();
        measure_open(has_hint_ ? &hint : nullptr);
        if (in_reach_) measure_in_reach();
        has_hint_ = !measured_.empty() && !(in_reach_ && measured_.front().candidate.stage == Stage::part_and_body);
        if (has_hint_) hint_ = measured_.front().candidate;
    }

    void find_every()
    {
        measured_.clear();
        if (in_reach_) list_bodies(options_.cutoff);
        push_self(), push_bodies();
        measure_open();
        // The least of the parts of each pair.
        const auto pair = [](const Measured& m) {
            return std::tuple(m.distance.link, m.distance.other, m.candidate.stage, of_body(m));
        };
        std::ranges::sort(measured_, [&](const Measured& a, const Measured& b) {
            return std::tuple(pair(a), order(a.distance)) < std::tuple(pair(b), order(b.distance));
        });
        std::size_t kept = 0;
        for (const Measured& m : measured_) {
            if (kept > 0 && pair(m) == pair(measured_[kept - 1])) {
                RobotDistance& nearest = measured_[kept - 1].distance;
                nearest.unique = nearest.unique && m.distance.lower > nearest.upper;
            } else {
                measured_[kept++] = m;
            }
        }
        measured_.resize(kept);
        std::ranges::stable_sort(measured_, {}, [](const Measured& m) { return order(m.distance); });
    }

    static std::tuple<double, double> order(const RobotDistance& d) { return {d.upper, d.lower}; }
    static std::uint32_t of_body(const Measured& m)
    {
        return m.candidate.stage == Stage::part_and_body ? m.candidate.b : 0;
    }

    /// Measures the bodies within the limit. Without a limit, nothing was measured yet: the reach grows until the
    /// nearest body in it is nearer than all beyond it.
    void measure_in_reach()
    {
        const bool grows = limit() == infinity;
        for (double reach = grows ? 1 : limit();;) {
            if (grows) measured_.clear();
            list_bodies(reach);
            push_bodies();
            measure_open();
            if (!grows || limit() <= reach || reach >= half_space_end) return;
            reach = limit() == infinity ? 4 * reach : limit();
        }
    }

    /// @param known  a pair that was measured before; null: none
    void measure_open(const Candidate* known = nullptr)
    {
        while (!open_.empty()) {
            std::ranges::pop_heap(open_, std::greater{}, &Candidate::order);
            const Candidate next = open_.back();
            open_.pop_back();
            if (next.lower > limit() || is_done()) break;
            if (next.stage == Stage::groups || next.stage == Stage::group_and_body)
                expand(next);
            else if (!known || !next.same(*known))
                measure(next);
        }
        open_.clear();
    }

    /// Replaces groups by their parts.
    void expand(const Candidate& c)
    {
        if (c.stage == Stage::groups) {
            const Robot::Impl::GroupPair& pair = robot_.group_pairs[c.b];
            for (std::uint32_t p = pair.first; p < pair.end; ++p) {
                const Robot::Impl::PartPair& parts = robot_.pairs[p];
                push({std::max(cull_.gap_of_parts(parts.a, parts.b), c.lower), Stage::parts, parts.a, parts.b});
            }
            return;
        }
        const Body& body = bodies_[c.b];
        if (robot_.allows(robot_.groups[c.a].link, tests_.body_at(body.slot))) return;
        for (std::uint32_t part = robot_.groups[c.a].first; part < robot_.groups[c.a].end; ++part) {
            const double gap = std::max(cull_.gap_of_part(part, body.own_box), c.lower);
            push({gap, Stage::part_and_body, part, c.b});
        }
    }

    void measure(const Candidate& c)
    {
        const bool with_body = c.stage == Stage::part_and_body;
        const Eigen::Isometry3d pose_a = robot_.pose_of(robot_.parts[c.a], poses_.data()),
                                pose_b = with_body ? tests_.pose_at(bodies_[c.b].slot)
                                                   : robot_.pose_of(robot_.parts[c.b], poses_.data());
        const PairTask task{0, models_[c.a], with_body ? &tests_.model_at(bodies_[c.b].slot) : models_[c.b], &pose_a,
                            &pose_b};
        Measured m{c, {}};
        RobotDistance& d = m.distance;
        d.link = robot_.parts[c.a].link;
        d.other = with_body ? RobotFinding::no_link : robot_.parts[c.b].link;
        if (with_body) d.body = tests_.body_at(bodies_[c.b].slot);
        const double cutoff = limit();
        const Distance found = tests_.distance(task, {.tolerance = options_.tolerance, .cutoff = cutoff});
        if (found.lower > cutoff || found.upper == infinity) return;
        d.lower = found.lower, d.upper = found.upper;
        d.point = found.point_a, d.other_point = found.point_b;
        if (found.lower <= 0)
            set_meeting(task, d);
        else
            d.normal = (found.point_b - found.point_a).normalized();
        if (found.lower > 0 && options_.gradients) d.unique = have_one_nearest_pair(task, found, d.normal);
        take(m);
    }

    /// Sets the depths and the contact of a pair that meets, or may.
    void set_meeting(const PairTask& task, RobotDistance& d)
    {
        d.unique = false;
        if (!options_.depths && d.upper <= 0) return;
        const Manifold& manifold = tests_.manifold(task, {.margin = d.upper});
        if (manifold.regions.empty()) {
            if (d.upper > 0) d.normal = (d.other_point - d.point).normalized();
            if (!manifold.complete) d.lower = -infinity;
            return;
        }
        const auto deepest = std::ranges::max_element(
            manifold.regions, {}, [](const ManifoldRegion& r) { return std::pair(r.depth_lower, r.depth_upper); });
        d.lower = d.upper = -deepest->depth_lower;
        for (const ManifoldRegion& r : manifold.regions) d.lower = std::min(d.lower, -r.depth_upper);
        d.normal = deepest->normal;
        const auto points = std::span(manifold.points).subspan(deepest->first, deepest->count);
        if (points.empty()) return;
        const ManifoldPoint& point = *std::ranges::max_element(points, {}, &ManifoldPoint::depth);
        d.point = point.point_a, d.other_point = point.point_b;
    }

    /// Keeps the nearest, or all.
    void take(const Measured& m)
    {
        if (options_.every_pair || measured_.empty()) {
            measured_.push_back(m);
            return;
        }
        Measured& best = measured_.front();
        const bool tie =
            std::max(m.distance.lower, best.distance.lower) <= std::min(m.distance.upper, best.distance.upper);
        if (std::tuple(order(m.distance), m.candidate.stage, m.candidate.a, m.candidate.b) <
            std::tuple(order(best.distance), best.candidate.stage, best.candidate.a, best.candidate.b))
            best = m;
        best.distance.unique = best.distance.unique && !tie;
    }

    void add(const double* numbers, const RobotDistance& d, RobotDistances& found)
    {
        found.pairs.push_back(d);
        if (!options_.gradients) return;
        const std::size_t first = found.gradients.size();
        found.gradients.resize(first + robot_.tree.width());
        const auto add_side = [&](std::uint32_t link, const Vector3d& point, const Vector3d& along) {
            robot_.tree.each_twist(numbers, poses_.data(), link, [&](std::uint32_t k, const Kinematics::Twist& t) {
                found.gradients[first + k] += along.dot(t.linear + t.angular.cross(point - t.origin));
            });
        };
        add_side(d.link, d.point, -d.normal);
        if (d.other != RobotFinding::no_link) add_side(d.other, d.other_point, d.normal);
    }

    const Robot::Impl& robot_;
    WorldAccess::PlacedTests tests_;
    SphereCull cull_;
    RobotDistanceOptions options_;
    std::vector<Model*> models_; ///< by part
    std::vector<std::uint32_t> own_;
    std::vector<Body> bodies_; ///< all bodies, or the bodies in reach
    bool in_reach_ = false;
    std::vector<Eigen::Isometry3d> poses_; ///< by link
    std::vector<Candidate> open_;          ///< a heap, the nearest first
    std::vector<Measured> measured_;
    Candidate hint_; ///< the nearest pair of the configuration before
    bool has_hint_ = false;
};

/// Finders of earlier calls.
struct Robot::Impl::IdleFinders : IdleCheckersOf<DistanceFinder> {};

std::shared_ptr<Robot::Impl::IdleFinders> Robot::Impl::no_finders()
{
    return std::make_shared<IdleFinders>();
}

void Robot::distances(const World& world, std::span<const double> configurations, RobotDistances& found,
                      const RobotDistanceOptions& options) const
{
    const Impl& p = *impl_;
    p.check_world(world);
    check_options(options);
    const std::size_t count = width() ? configurations.size() / width() : 0;
    p.check_numbers("distances", "configuration", *this, configurations, count);
    std::vector<RobotDistances> parts((count + configurations_per_chunk - 1) / configurations_per_chunk);
    each_chunk(
        world, count, configurations_per_chunk, [&] { return p.idle_finders->lease(p, world, options); },
        [&](DistanceFinder& finder, std::size_t first, std::size_t items) {
            finder.run(configurations.subspan(first * width(), items * width()), first, items,
                       parts[first / configurations_per_chunk]);
        });
    found.offsets.assign(1, 0), found.pairs.clear(), found.gradients.clear();
    for (const RobotDistances& part : parts) {
        for (const std::size_t end : part.offsets) found.offsets.push_back(found.pairs.size() + end);
        found.pairs.insert(found.pairs.end(), part.pairs.begin(), part.pairs.end());
        found.gradients.insert(found.gradients.end(), part.gradients.begin(), part.gradients.end());
    }
}

} // namespace oncollide
