// The kinds of contact: touching, crossing, enclosed, near.
#include <functional>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/motion.hpp>

#include "narrowphase/mesh_parts.hpp"
#include "truth/scene_truth.hpp"

namespace oncollide {
namespace {

Scene two(const Mesh& a, const Mesh& b)
{
    Scene scene;
    scene.add_body({.name = "a", .geometry = scene.add("a", a), .motion = Drift{}});
    scene.add_body({.name = "b", .geometry = scene.add("b", b), .motion = Drift{}});
    return scene;
}

Scene two_boxes()
{
    return two(make_box_mesh({0.5, 0.5, 0.5}), make_box_mesh({0.5, 0.5, 0.5}));
}

Settings with_kinds()
{
    Settings settings;
    settings.exact = ExactLevel::predicates, settings.contact_kinds = true;
    return settings;
}

PairResult at(Pipeline& pipeline, Scene& scene, const Eigen::Vector3d& place)
{
    scene.set_position(SceneBodyId{1}, place);
    const FrameView frame = pipeline.step(scene);
    return frame.pairs.empty() ? PairResult{{Verdict::separate, ContactKind::unknown, 0}, StageId::bounds, {}, {}}
                               : frame.pairs[0];
}

/// The strongest contact of any two triangles.
TriangleContact brute_force(const Scene& scene)
{
    const RelativePose b_to_a(scene.poses[0], scene.poses[1]);
    const Mesh &a = std::get<Mesh>(scene.geometries[0].data), &b = std::get<Mesh>(scene.geometries[1].data);
    TriangleContact most = TriangleContact::separate;
    for (const Triangle& t : a.triangles)
        for (const Triangle& u : b.triangles) {
            const TrianglePoints p{a.vertices[t[0]], a.vertices[t[1]], a.vertices[t[2]]};
            const TrianglePoints q{b_to_a(b.vertices[u[0]]), b_to_a(b.vertices[u[1]]), b_to_a(b.vertices[u[2]])};
            most = std::max(most, triangle_contact(p, q));
        }
    return most;
}

TEST(ContactKinds, TellTouchingFromCrossingToTheLastBit)
{
    Scene scene = two_boxes();
    Pipeline pipeline(scene, with_kinds());
    const auto kind = [&](double x, double y, double z) { return at(pipeline, scene, {x, y, z}).kind; };
    for (const double y : {0.0, 0.05, 1.0})
        for (const double z : {0.0, 0.3, 1.0}) {
            EXPECT_EQ(kind(1, y, z), ContactKind::touching) << y << ' ' << z;
            EXPECT_EQ(kind(std::nextafter(1, 2), y, z), ContactKind::unknown) << y << ' ' << z;
        }
    EXPECT_EQ(kind(std::nextafter(1, 0), 0.05, 0.3), ContactKind::crossing) << "an ulp deep, without coplanar faces";
    EXPECT_EQ(kind(0.9, 0.1, 0.1), ContactKind::crossing);
    EXPECT_EQ(kind(0, 0, 0), ContactKind::crossing) << "the same mesh in the same pose";
    EXPECT_EQ(kind(0.95, 0, 0), ContactKind::crossing) << "walls overlap, although all pairs of triangles only touch";
}

/// Many frames, so that hints of touching triangles meet crossing ones and vice versa.
TEST(ContactKinds, EqualBruteForceOverAllPairsOfTriangles)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300), box = make_box_mesh({0.5, 0.5, 0.5}),
               soup = make_soup_mesh(60, 0.4, 1, 6);
    int count[3] = {};
    for (const auto& [a, b] : {std::pair(&box, &box), std::pair(&knot, &box), std::pair(&knot, &soup)}) {
        Scene scene = two(*a, *b);
        Pipeline pipeline(scene, with_kinds());
        Settings alone = with_kinds();
        alone.coherence = false, alone.bounding_volume = BoundingVolume::sphere;
        Pipeline without_hints(scene, alone);
        for (std::uint64_t frame = 0; frame < 120; ++frame) {
            Eigen::Vector3d place;
            // Multiples of a quarter, so that faces, edges and corners often coincide.
            for (std::uint64_t k = 0; k < 3; ++k) place[int(k)] = 0.25 * std::floor(8 * u01(7, frame, k)) - 1;
            const PairResult result = at(pipeline, scene, place);
            TriangleContact truth = brute_force(scene);
            if (truth == TriangleContact::touching && a == &box && place.cwiseAbs().maxCoeff() < 1)
                truth = TriangleContact::crossing; // insides overlap
            ++count[int(truth)];
            const ContactKind kind = truth == TriangleContact::crossing   ? ContactKind::crossing
                                     : truth == TriangleContact::touching ? ContactKind::touching
                                                                          : ContactKind::unknown;
            EXPECT_EQ(result.kind, kind) << frame;
            EXPECT_EQ(result.verdict == Verdict::colliding, truth != TriangleContact::separate) << frame;
            EXPECT_EQ(at(without_hints, scene, place).kind, kind) << frame;
        }
    }
    for (int truth : count) EXPECT_GE(truth, 20) << "the poses must produce every result often";
}

TEST(ContactKinds, OfASlideThatKeepsTouchingShowACrossingElsewhere)
{
    const Mesh box = make_box_mesh({0.5, 0.5, 0.5}), wall = make_box_mesh({0.5, 3, 3});
    const Mesh tip = make_mesh("tip", {{-0.5, 0, 0}, {0, 0.1, 0.2}, {0, -0.2, 0.1}, {0, 0.1, -0.2}},
                               {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}); // open, so it has no inside
    Scene scene = two(joined({wall, moved(box, {2.3, 1.2, 11.2})}), joined({tip, moved(box, {1, 0, 10})}));
    Pipeline pipeline(scene, with_kinds());
    for (const double y : {0.0, 0.1, 0.3, 0.1}) // triangles that touched last time still touch
        EXPECT_EQ(at(pipeline, scene, {1, y, 1}).kind, y > 0.2 ? ContactKind::crossing : ContactKind::touching) << y;
}

TEST(ContactKinds, ChangeNoVerdictAndNoBound)
{
    Scene scene = two_boxes();
    Settings plain;
    plain.exact = ExactLevel::predicates;
    for (const double clearance : {0.0, 0.2}) {
        Settings asking = with_kinds();
        plain.clearance = asking.clearance = clearance;
        Pipeline without(scene, plain), with(scene, asking);
        for (double x = 0.8; x < 1.4; x += 0.05) {
            const PairResult a = at(without, scene, {x, 0.1, 0.2}), b = at(with, scene, {x, 0.1, 0.2});
            EXPECT_EQ(a.verdict, b.verdict) << x;
            EXPECT_EQ(a.bound, b.bound) << x;
        }
    }
}

TEST(ContactKinds, SeeNoInsideInSurfaceMode)
{
    Scene scene = two(make_box_mesh({0.5, 0.5, 0.5}), make_box_mesh({0.1, 0.1, 0.1}));
    Pipeline pipeline(scene, with_kinds());
    EXPECT_EQ(at(pipeline, scene, {0.1, 0, 0}).verdict, Verdict::separate);

    Mesh tray = make_box_mesh({0.5, 0.5, 0.5});
    tray.triangles.pop_back();
    scene = two(tray, tray);
    Pipeline open(scene, with_kinds());
    EXPECT_EQ(at(open, scene, {0.95, 0, 0}).kind, ContactKind::touching) << "no inside to share";
}

TEST(ContactKinds, AreNearInsideAClearance)
{
    Scene scene = two_boxes();
    for (const ExactLevel exact : {ExactLevel::predicates, ExactLevel::fcl}) {
        Pipeline pipeline(scene, {.clearance = 0.25, .exact = exact});
        EXPECT_EQ(at(pipeline, scene, {1.125, 0, 0}).kind, ContactKind::near);
        EXPECT_EQ(at(pipeline, scene, {1.5, 0, 0}).kind, ContactKind::unknown);
        EXPECT_EQ(at(pipeline, scene, {0.9, 0.1, 0}).kind, ContactKind::unknown) << "nobody asked";
    }
}

TEST(ContactKinds, TouchingCanBeIgnored)
{
    Scene scene = two_boxes();
    Settings settings = with_kinds();
    settings.contact_kinds = false, settings.ignore_touching = true;
    Pipeline pipeline(scene, settings);
    for (int round = 0; round < 2; ++round) { // the second round uses the hints of the first
        const PairResult touching = at(pipeline, scene, {1, 0.05, 0.3});
        EXPECT_EQ(touching.verdict, Verdict::separate);
        EXPECT_EQ(touching.kind, ContactKind::touching);
        EXPECT_EQ(touching.bound, 0);
        const PairResult crossing = at(pipeline, scene, {std::nextafter(1, 0), 0.05, 0.3});
        EXPECT_EQ(crossing.verdict, Verdict::colliding);
        EXPECT_EQ(crossing.kind, ContactKind::crossing);
        EXPECT_EQ(at(pipeline, scene, {0.95, 0, 0}).verdict, Verdict::colliding) << "coplanar, but 5 cm deep";
    }
}

TEST(ContactKinds, IgnoredPairsAreNotHeldToBeMissed)
{
    Scene scene = two_boxes();
    scene.set_position(SceneBodyId{1}, Eigen::Vector3d(1, 0.05, 0.3));
    Settings settings = with_kinds();
    settings.contact_kinds = false, settings.ignore_touching = true;
    tools::SceneTruth truth(scene, settings);
    truth.step();
    ASSERT_EQ(truth.near().size(), 1u);
    Pipeline pipeline(scene, settings);
    const FrameView frame = pipeline.step(scene);
    EXPECT_EQ(judge(frame.pairs, truth, scene, settings, {.bounds = 1}).missed, 0u);
    settings.ignore_touching = false;
    EXPECT_EQ(judge(frame.pairs, truth, scene, settings, {.bounds = 1}).missed, 1u);
}

TEST(ContactKinds, GiveOneHashForThreadsAndCoherence)
{
    const auto hash = [](int threads, bool coherence, bool kinds) {
        Scene scene;
        const GeometryId knot = scene.add("knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300)),
                         box = scene.add("box", make_box_mesh({0.5, 0.5, 0.5}));
        for (std::uint64_t i = 0; i < 60; ++i) {
            BodyInit body{.name = std::to_string(i), .geometry = i % 2 ? knot : box, .motion = Drift{}};
            for (std::uint64_t k = 0; k < 3; ++k) body.pose.translation()[int(k)] = 0.5 * std::floor(8 * u01(1, i, k));
            scene.add_body(body);
        }
        Settings settings = with_kinds();
        settings.contact_kinds = kinds, settings.threads = threads, settings.coherence = coherence;
        Pipeline pipeline(scene, settings);
        for (int frame = 0; frame < 4; ++frame) {
            pipeline.step(scene);
            for (std::uint32_t i = 0; i < scene.size(); i += 3)
                scene.set_position(SceneBodyId{i}, scene.poses.position(i) + 0.25 * Eigen::Vector3d::UnitX());
        }
        return pipeline.hash();
    };
    const std::uint64_t expected = hash(1, true, true);
    EXPECT_EQ(hash(3, true, true), expected);
    EXPECT_EQ(hash(1, false, true), expected);
    EXPECT_NE(hash(1, true, false), expected) << "kinds are part of the hash if they were requested";
}

TEST(ContactKinds, RefuseWhatCannotBeAnswered)
{
    const auto refuses = [](const std::function<void(Settings&)>& change, const char* word) {
        Settings settings = with_kinds();
        change(settings);
        try {
            check(settings);
            ADD_FAILURE() << "accepted: " << word;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::usage);
            EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
        }
    };
    refuses([](Settings& s) { s.exact = ExactLevel::fcl; }, "predicates");
    refuses([](Settings& s) { s.contact_kinds = false, s.ignore_touching = true, s.exact = ExactLevel::off; },
            "predicates");
    refuses([](Settings& s) { s.ignore_touching = true, s.mode = Mode::solid; }, "surface");
    refuses([](Settings& s) { s.ignore_touching = true, s.clearance = 0.1; }, "clearance");
}

} // namespace
} // namespace oncollide
