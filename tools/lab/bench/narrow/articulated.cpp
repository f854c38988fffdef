#include "bench/narrow/articulated.hpp"

#include <cmath>
#include <numbers>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "common/statistics.hpp"

namespace oncollide::tools {
namespace {

using Eigen::AngleAxisd, Eigen::Isometry3d, Eigen::Translation3d, Eigen::Vector3d;

/// A link hangs from a joint of another one, and swings about the y axis.
struct Link {
    int parent;    ///< -1: walks along x
    Vector3d half; ///< of its ellipsoid, m
    Vector3d joint, centre;
    double swing, phase; ///< radians
};

constexpr double pi = std::numbers::pi;

std::vector<Link> links()
{
    std::vector<Link> all{{-1, {0.1, 0.16, 0.1}, {0, 0, 0.95}, {0, 0, 0}, 0.05, 0},
                          {0, {0.11, 0.2, 0.28}, {0, 0, 0.1}, {0, 0, 0.29}, 0.1, 0.5},
                          {1, {0.09, 0.08, 0.12}, {0, 0, 0.6}, {0, 0, 0.13}, 0.15, 1}};
    for (const double side : {-1.0, 1.0}) {
        const double phase = side > 0 ? 0 : pi;
        const int first = int(all.size());
        all.push_back({1, {0.05, 0.05, 0.17}, {0, 0.27 * side, 0.5}, {0, 0, -0.18}, 0.6, phase});
        all.push_back({first, {0.04, 0.04, 0.15}, {0, 0, -0.36}, {0, 0, -0.16}, 0.5, phase + 0.4});
        all.push_back({first + 1, {0.045, 0.02, 0.09}, {0, 0, -0.32}, {0, 0, -0.1}, 0.3, phase + 0.8});
        all.push_back({0, {0.08, 0.08, 0.23}, {0, 0.1 * side, -0.08}, {0, 0, -0.24}, 0.6, phase + pi});
        all.push_back({first + 3, {0.06, 0.06, 0.22}, {0, 0, -0.48}, {0, 0, -0.23}, 0.4, phase + pi + 0.5});
        all.push_back({first + 4, {0.13, 0.05, 0.04}, {0, 0, -0.47}, {0.07, 0, -0.04}, 0.2, phase + pi + 1});
    }
    return all;
}

Mesh mesh_of(const Vector3d& half, int triangles)
{
    Mesh mesh = make_sphere_mesh(1, triangles);
    for (Vector3d& v : mesh.vertices) v = v.cwiseProduct(half);
    return make_mesh("link", std::move(mesh.vertices), std::move(mesh.triangles));
}

/// @param time  in steps
std::vector<Isometry3d> poses_at(const std::vector<Link>& links, double time)
{
    constexpr double stride = 0.04, beat = 0.12; // m and radians in a step
    std::vector<Isometry3d> joints, poses;
    for (const Link& link : links) {
        Isometry3d joint(Translation3d(link.joint) *
                         AngleAxisd(link.swing * std::sin(beat * time + link.phase), Vector3d::UnitY()));
        joint = link.parent < 0 ? Isometry3d(Translation3d(stride * time, 0, 0) * joint)
                                : Isometry3d(joints[std::size_t(link.parent)] * joint);
        joints.push_back(joint);
        poses.push_back(joint * Translation3d(link.centre));
    }
    return poses;
}

class Walk {
public:
    explicit Walk(double tolerance)
    {
        constexpr int of_a_link = 1334, of_a_post = 200;
        constexpr std::size_t posts = 12;
        world_.set_sweep_options({.time_tolerance = tolerance, .gap_tolerance = tolerance});
        const std::vector<Isometry3d> at_start = poses_at(links_, 0);
        for (std::size_t i = 0; i < links_.size(); ++i) {
            models_.push_back(world_.models().add(mesh_of(links_[i].half, of_a_link)));
            bodies_.push_back(world_.bodies().add({.model = models_.back(), .pose = at_start[i]}));
            if (links_[i].parent >= 0) world_.bodies().exclude(bodies_[std::size_t(links_[i].parent)], bodies_[i]);
        }
        result.links = links_.size(), result.triangles = links_.size() * mesh_of({1, 1, 1}, of_a_link).triangles.size();
        const Mesh post = mesh_of({0.05, 0.05, 1.2}, of_a_post);
        result.posts = posts, result.triangles_of_posts = posts * post.triangles.size();
        models_.push_back(world_.models().add(post));
        for (std::size_t k = 0; k < posts; ++k) {
            const double beside = 0.26 + 0.04 * double(k % 5); // the first of five are in the way of the arms
            places_.push_back(Isometry3d(Translation3d(1.2 * double(k) + 0.6, k % 2 ? beside : -beside, 0.6)));
            posts_.push_back(world_.bodies().add({.model = models_.back(), .pose = places_.back(), .is_static = true}));
        }
        world_.step();
    }
    void step(int number, int samples)
    {
        const std::vector<Isometry3d> from = poses_at(links_, number), to = poses_at(links_, number + 1);
        const auto began = Clock::now();
        world_.bodies().set_motion(bodies_, to);
        const FrameView frame = world_.step();
        result.us.push_back(1000 * milliseconds_since(began));
        std::vector<double> clear(links_.size() * slots(), 1);
        for (const PairSweep& sweep : frame.sweeps) {
            const PairResult& pair = frame.pairs[sweep.pair];
            clear[index(pair.a) * slots() + index(pair.b)] = sweep.clear_until;
            result.contacts += sweep.verdict == Verdict::colliding;
        }
        std::vector<RigidMotion> ways;
        for (std::size_t i = 0; i < links_.size(); ++i) ways.emplace_back(from[i], to[i]);
        for (std::size_t k = 0; k < places_.size(); ++k) ways.emplace_back(places_[k]);
        for (int k = 0; k < samples; ++k) check(double(k) / samples, ways, clear);
    }

    ArticulatedResult result;

private:
    std::size_t slots() const { return links_.size() + places_.size(); }
    void check(double time, const std::vector<RigidMotion>& ways, const std::vector<double>& clear)
    {
        for (std::size_t a = 0; a < links_.size(); ++a)
            for (std::size_t b = a + 1; b < slots(); ++b) {
                if (time >= clear[a * slots() + b] || (b < links_.size() && links_[b].parent == int(a))) continue;
                const PlacedModel of_a{models_[a], ways[a].pose(time)},
                    of_b{models_[std::min(b, links_.size())], ways[b].pose(time)};
                result.contradicted += world_.pairs().decide(of_a, of_b).verdict == Verdict::colliding;
            }
    }

    World world_;
    std::vector<Link> links_ = links();
    std::vector<ModelId> models_; ///< of the links, then of the posts
    std::vector<BodyId> bodies_, posts_;
    std::vector<Isometry3d> places_;
};

} // namespace

ArticulatedResult walk_articulated_body(int steps, double tolerance, int samples)
{
    Walk walk(tolerance);
    for (int k = 0; k < steps; ++k) walk.step(k, samples);
    return std::move(walk.result);
}

} // namespace oncollide::tools
