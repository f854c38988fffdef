// World::manifolds() keeps manifolds between frames, which changes no result.
#include <random>

#include "allocations.hpp"
#include "pipeline/manifold_scenes.hpp"

namespace oncollide::manifold_scenes {
namespace {

/// Bodies of all kinds that stand close together.
struct Crowd {
    World world;
    std::vector<ModelId> models;
    std::vector<BodyId> bodies;
    std::mt19937_64 random{7};

    explicit Crowd(int threads, std::size_t count = 20) : world({.clearance = 0.02, .threads = threads})
    {
        for (std::size_t kind = 0; kind + 1 < kinds; ++kind)
            models.push_back(world.models().add(
                std::make_shared<const Geometry>(Geometry{every_kind[kind], draw_geometry(kind, kind), {}})));
        for (std::size_t i = 0; i < count; ++i) add();
    }
    double draw(double most) { return std::uniform_real_distribution<double>(-most, most)(random); }
    void add()
    {
        bodies.push_back(world.bodies().add({.model = models[random() % models.size()],
                                             .pose = random_pose(random(), 1.2),
                                             .is_static = random() % 4 == 0}));
    }
    void change() ///< mostly small moves of few bodies; seldom rest, jumps, removals and additions
    {
        const std::uint64_t what = random() % 40;
        if (what < 4) return;
        if (what == 4) {
            const std::size_t gone = random() % bodies.size();
            world.bodies().remove(bodies[gone]), bodies.erase(bodies.begin() + std::ptrdiff_t(gone));
            return add();
        }
        for (std::size_t i = 0; i < 1 + random() % 4; ++i) {
            const BodyId body = bodies[random() % bodies.size()];
            Isometry3d pose = world.bodies().pose(body);
            if (what == 5)
                pose = random_pose(random(), 1.2);
            else
                pose.translation() += Vector3d(draw(1e-3), draw(1e-3), draw(1e-3));
            world.bodies().set_pose(body, pose);
        }
    }
};

std::uint64_t fresh_hash(const World& world, const FrameManifolds& found, const ManifoldOptions& options)
{
    ManifoldLists lists;
    world.pairs().manifold(found.pairs, options, lists);
    return hash_of(lists);
}

TEST(FrameManifolds, AreThoseOfTheirPairsInTenThousandFrames)
{
    Crowd crowd(1, 10);
    std::size_t regions = 0;
    for (int frame = 0; frame < 10'000; ++frame) {
        crowd.change();
        const ManifoldOptions options{.margin = frame / 100 % 2 ? 0.01 : 0};
        crowd.world.step();
        const FrameManifolds& found = crowd.world.manifolds(options);
        ASSERT_EQ(hash_of(found), fresh_hash(crowd.world, found, options)) << frame;
        regions += found.regions.size();
    }
    EXPECT_GT(regions, 50'000u);
}

TEST(FrameManifolds, HaveEveryPairThatHasARegionForAnyNumberOfThreads)
{
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 8}) {
        Crowd crowd(threads, 60);
        std::uint64_t hash = 0;
        for (int frame = 0; frame < 12; ++frame) {
            crowd.change();
            const FrameView view = crowd.world.step();
            std::vector<PairOfBodies> with_regions;
            for (const PairResult& pair : view.pairs)
                if (!crowd.world.pairs().manifold(pair.a, pair.b, {.margin = 0.01}).regions.empty())
                    with_regions.push_back({pair.a, pair.b});
            const FrameManifolds& found = crowd.world.manifolds({.margin = 0.01});
            ASSERT_EQ(found.pairs, with_regions) << threads << " " << frame;
            hash = hash * 31 + hash_of(found);
        }
        hashes.push_back(hash);
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(FrameManifolds, AtRestAreTheSameLists)
{
    Crowd crowd(1);
    crowd.world.step();
    const FrameManifolds& first = crowd.world.manifolds();
    const ManifoldPoint* points = first.points.data();
    const std::uint64_t hash = hash_of(first);
    for (int frame = 0; frame < 3; ++frame) {
        crowd.world.step();
        EXPECT_EQ(crowd.world.manifolds().points.data(), points);
    }
    EXPECT_EQ(hash_of(crowd.world.manifolds()), hash);
    // Other options, and back.
    (void)crowd.world.manifolds({.measures = true});
    EXPECT_EQ(hash_of(crowd.world.manifolds()), hash);
    const FrameManifolds& few = crowd.world.manifolds({.points_in_all = 3});
    EXPECT_EQ(few.points.size(), 3u);
}

/// Moves bodies up and down; after 20 frames, manifolds take no more memory. @param least  points in each frame
void expect_no_allocation(World& world, const std::vector<BodyId>& bodies, double height, std::size_t least)
{
    for (int frame = 0; frame < 40; ++frame) {
        for (const BodyId body : bodies) {
            Isometry3d pose = world.bodies().pose(body);
            pose.translation().z() = height + 1e-3 * std::sin(frame + body.slot);
            world.bodies().set_pose(body, pose);
        }
        world.step();
        const std::size_t before = allocations;
        const FrameManifolds& found = world.manifolds({.margin = 0.01});
        const std::size_t after = allocations;
        EXPECT_GE(found.points.size(), least);
        if (frame >= 20) {
            EXPECT_EQ(after, before) << frame;
        }
    }
}

TEST(FrameManifolds, OfShapesAllocateNothingWhenWarm)
{
    World world({.clearance = 0.01, .threads = 1});
    std::vector<BodyId> bodies;
    for (const Shape& shape : {Shape(Box{{0.5, 0.5, 0.5}}), Shape(Sphere{0.5}), Shape(Capsule{0.4, 0.5}),
                               Shape(Cylinder{0.5, 1}), Shape(Ellipsoid{{0.5, 0.4, 0.6}})})
        for (int i = 0; i < 3; ++i)
            bodies.push_back(
                world.bodies().add({.model = world.models().add(shape),
                                    .pose = at(0.9 * double(bodies.size() % 4), 0.9 * double(bodies.size() / 4), 0)}));
    expect_no_allocation(world, bodies, 0, 11);
}

TEST(FrameManifolds, OfShapesOnTrianglesAllocateNothingWhenWarm)
{
    for (const bool near : {false, true})
        for (const GeometryData& ground : {GeometryData(flat_terrain()), GeometryData(make_box_mesh({5, 5, 1}))}) {
            World world({.clearance = 0.01, .threads = 1});
            const double top = std::holds_alternative<Terrain>(ground) ? 0 : 1;
            world.bodies().add({.model = world.models().add(std::make_shared<const Geometry>(Geometry{"", ground, {}})),
                                .pose = at(0, 0, -top),
                                .is_static = true});
            std::vector<BodyId> bodies;
            for (const Shape& shape : {Shape(Box{{0.3, 0.3, 0.3}}), Shape(Sphere{0.3}), Shape(Capsule{0.3, 0.4}),
                                       Shape(ConvexHull{make_sphere_mesh(0.3, 80).vertices})})
                for (int i = 0; i < 3; ++i)
                    bodies.push_back(world.bodies().add(
                        {.model = world.models().add(shape),
                         .pose = at(double(bodies.size() % 4) - 2, double(bodies.size() / 4) - 2, 0.3)}));
            expect_no_allocation(world, bodies, near ? 0.303 : 0.298, 18);
        }
}

TEST(FrameManifolds, NeedAFrameOfTheBodiesAsTheyAre)
{
    World world;
    EXPECT_THROW((void)world.manifolds(), Error);
    const ModelId ball = world.models().add(Shape(Sphere{1}));
    const BodyId a = world.bodies().add({.model = ball});
    (void)world.bodies().add({.model = ball, .pose = at(1, 0, 0)});
    world.step();
    EXPECT_EQ(world.manifolds().pairs.size(), 1u);
    world.bodies().set_pose(a, at(-5, 0, 0));
    EXPECT_THROW((void)world.manifolds(), Error);
    world.step();
    EXPECT_EQ(world.manifolds().pairs.size(), 0u);
    EXPECT_THROW((void)world.manifolds({.margin = -1}), Error);
}

} // namespace
} // namespace oncollide::manifold_scenes
