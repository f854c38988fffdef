// Robot::edge_clearance(): branch and bound over pairs and windows of time.
#include <oncollide/robots/edges/edge_motion.hpp>
#include <oncollide/robots/surroundings.hpp>

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include <oncollide/pipeline/world/placed_tests.hpp>

namespace oncollide {

namespace {

constexpr std::size_t clearances_per_chunk = 4;

} // namespace

/// Measures edges one by one; one per thread.
class Robot::EdgeMeasure {
public:
    EdgeMeasure(const Robot::Impl& robot, const World& world, const RobotClearanceOptions& options)
        : robot_(robot), options_(options), tests_(world), cull_(robot, 0), motion_(robot),
          own_(robot.own_slots(world)), bodies_(tests_)
    {
        tests_.begin();
        for (const Robot::Impl::Part& part : robot.parts) models_.push_back(&tests_.model(part.model));
    }

    /// @param found  in: a distance on the edge
    void run(const double* from, const double* to, RobotEdgeClearance& found)
    {
        found_ = &found, open_.clear(), culled_at_ = -1;
        if (found.upper <= 0) {
            found.lower = 0;
            return;
        }
        motion_.start(from, to);
        motion_.place(0.5);
        if (options_.pairs.self)
            for (const Robot::Impl::PartPair& pair : robot_.pairs) push({0, 1, pair.a, pair.b, {}, pair.seen_from}, 0);
        if (options_.pairs.environment) push_bodies();
        std::size_t tests = 0;
        while (!open_.empty() && found.upper > 0 && tests < options_.most_tests) {
            if (open_.front().lower >= found.upper - options_.tolerance) break;
            std::ranges::pop_heap(open_, std::greater{}, &Window::order);
            const Window window = open_.back();
            open_.pop_back();
            ++tests;
            halve(window);
        }
        found.lower = open_.empty() ? found.upper : std::clamp(open_.front().lower, 0.0, found.upper);
        if (found.upper <= 0) found.lower = found.upper = 0;
    }

private:
    struct Window {
        EdgeItem item; ///< its box is a number of bodies_
        double lower;  ///< bound of the pair's distance in the window

        std::tuple<double, double, std::uint32_t, std::uint32_t, std::uint32_t> order() const
        {
            return {lower, item.begin, item.a, item.b, item.body.slot};
        }
    };

    const Eigen::Isometry3d* place(double share)
    {
        const Eigen::Isometry3d* const links = motion_.place(share);
        if (share != culled_at_) cull_.place(links), culled_at_ = share;
        return links;
    }
    void push(const Window& window)
    {
        if (window.lower >= found_->upper) return;
        open_.push_back(window);
        std::ranges::push_heap(open_, std::greater{}, &Window::order);
    }
    /// Adds a window with the bound from bounding spheres, or a larger one that is known.
    void push(const EdgeItem& item, double known)
    {
        place(item.middle());
        const double gap =
            item.b == no_part ? cull_.gap_of_part(item.a, bodies_[item.box].box) : cull_.gap_of_parts(item.a, item.b);
        push({item, std::max(known, gap - motion_.reach(motion_.ways_of(item)))});
    }
    void push_bodies()
    {
        const std::uint32_t root = robot_.tree.root();
        bodies_.clear();
        std::vector<Aabb> around;
        for (std::uint32_t part = 0; part < robot_.parts.size(); ++part) {
            const Robot::Impl::Part& of = robot_.parts[part];
            const BallTravel way = motion_.travel({0, 1, part, no_part, {}, root}, of.cover.whole, of.link);
            const double reach = (way.moved + of.cover.whole.radius) * robot_.stretch() + found_->upper;
            const Eigen::Vector3d at = motion_.middle().links[of.link] * of.cover.whole.centre;
            const double all = std::min(reach * (1 + 1e-12) + 1e-12 * at.norm(), 2 * half_space_end);
            around.push_back({at.array() - all, at.array() + all});
        }
        for (const AabbHit& hit : tests_.around(around, options_.pairs.filter)) {
            const BodyId body = tests_.body_at(hit.body);
            if (std::ranges::binary_search(own_, hit.body) || robot_.allows(robot_.parts[hit.query].link, body))
                continue;
            push({0, 1, hit.query, no_part, body, root, bodies_.number_of(hit.body)}, 0);
        }
    }

    /// Measures the pair in the middle of the window.
    void halve(const Window& window)
    {
        const EdgeItem& item = window.item;
        const bool with_body = item.b == no_part;
        const Eigen::Isometry3d* const links = place(item.middle());
        const double reach = motion_.reach(motion_.ways_of(item));
        const Eigen::Isometry3d pose_a = robot_.pose_of(robot_.parts[item.a], links),
                                pose_b = with_body ? tests_.pose_at(item.body.slot)
                                                   : robot_.pose_of(robot_.parts[item.b], links);
        const PairTask task{0, models_[item.a], with_body ? &tests_.model_at(item.body.slot) : models_[item.b], &pose_a,
                            &pose_b};
        const double cutoff = found_->upper + reach;
        const Distance d = tests_.distance(task, {.tolerance = 0.25 * options_.tolerance, .cutoff = cutoff});
        if (d.upper < found_->upper) {
            const std::uint32_t other = with_body ? RobotFinding::no_link : robot_.parts[item.b].link;
            *found_ = {0, d.upper, item.middle(), robot_.parts[item.a].link, other, item.body};
        }
        const double lower = std::max(d.lower - reach, window.lower);
        if (lower >= found_->upper - options_.tolerance) {
            push({item, lower}); // it need not be halved, but its bound counts
            return;
        }
        EdgeItem first = item, second = item;
        first.end = second.begin = item.middle();
        push(first, lower), push(second, lower);
    }

    const Robot::Impl& robot_;
    const RobotClearanceOptions& options_;
    WorldAccess::PlacedTests tests_;
    SphereCull cull_;
    EdgeMotion motion_;
    const std::vector<std::uint32_t> own_; ///< slots of the robot's bodies
    std::vector<Model*> models_;           ///< by part
    double culled_at_ = -1;
    RobotEdgeClearance* found_ = nullptr;
    PlacedBodies bodies_;
    std::vector<Window> open_; ///< a heap, the least bound first
};

void Robot::edge_clearance(const World& world, std::span<const double> from, std::span<const double> to,
                           std::span<RobotEdgeClearance> found, const RobotClearanceOptions& options) const
{
    const Impl& p = *impl_;
    p.check_world(world);
    p.check_numbers("edge_clearance", "start", *this, from, found.size());
    p.check_numbers("edge_clearance", "end", *this, to, found.size());
    if (!(options.tolerance > 0))
        throw Error(ErrorKind::usage,
                    fmt::format("robot: edge_clearance: a tolerance of {}; must be above 0", options.tolerance));
    // A distance on each edge: the nearest of both ends and some places between them.
    constexpr std::size_t samples = 5;
    std::vector<double> numbers(found.size() * samples * width());
    for (std::size_t i = 0; i < found.size(); ++i)
        for (std::size_t k = 0; k < samples; ++k)
            p.tree.between(&from[i * width()], &to[i * width()], double(k) / (samples - 1),
                           &numbers[(i * samples + k) * width()]);
    RobotDistances at;
    distances(world, numbers, at, {.pairs = options.pairs, .gradients = false, .depths = false});
    for (std::size_t i = 0; i < found.size(); ++i) {
        found[i] = {};
        for (std::size_t k = 0; k < samples; ++k)
            for (std::size_t n = at.offsets[i * samples + k]; n < at.offsets[i * samples + k + 1]; ++n)
                if (const RobotDistance& d = at.pairs[n]; d.upper < found[i].upper)
                    found[i] = {0, d.upper, double(k) / (samples - 1), d.link, d.other, d.body};
    }
    each_chunk(
        world, found.size(), clearances_per_chunk, [&] { return std::make_unique<EdgeMeasure>(p, world, options); },
        [&](EdgeMeasure& measure, std::size_t first, std::size_t count) {
            for (std::size_t i = first; i < first + count; ++i)
                measure.run(&from[i * width()], &to[i * width()], found[i]);
        });
}

} // namespace oncollide
