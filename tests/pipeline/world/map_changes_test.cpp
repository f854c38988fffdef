// Maps whose cells change while a World runs: its results must equal the results of a new World with the changed map.
#include <map>
#include <random>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/geometry.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace {

using Eigen::Vector3d;

using Outcome = std::map<std::pair<std::uint64_t, std::uint64_t>, std::tuple<Verdict, ContactKind, double>>;

Outcome outcome_of(World& world)
{
    Outcome outcome;
    for (const PairResult& pair : world.step().pairs) {
        if (pair.verdict == Verdict::separate) continue; // pairs of boxes that do not overlap are not reported
        const std::uint64_t a = world.bodies().user(pair.a), b = world.bodies().user(pair.b);
        outcome[{std::min(a, b), std::max(a, b)}] = {pair.verdict, pair.kind, pair.bound};
    }
    return outcome;
}

const OccupancyMap& map_of(const World& world, ModelId model)
{
    return std::get<OccupancyMap>(world.models().geometry(model).data);
}

/// Bodies of all kinds around the map, which is model 0 and body 0.
struct Place {
    World world;
    std::vector<ModelId> models;
    std::vector<BodyId> bodies;

    Place(const Settings& settings, const OccupancyMap& map) : world(settings)
    {
        models = {world.models().add(map, "map"),
                  world.models().add(make_sphere_mesh(0.4, 120)),
                  world.models().add(make_box_mesh({0.1, 0.1, 0.1})),
                  world.models().add(Shape(Sphere{0.3})),
                  world.models().add(Shape(Box{{0.5, 0.3, 0.2}})),
                  world.models().add(Shape(Capsule{0.2, 0.6})),
                  world.models().add(Shape(Cylinder{0.2, 0.5})),
                  world.models().add(make_building_map(1, 1.0, 4))};
        bodies.push_back(world.bodies().add({.model = models[0], .is_static = true}));
        for (std::uint64_t i = 1; i <= 40; ++i)
            bodies.push_back(world.bodies().add({.model = models[1 + i % 7], .pose = random_pose(i, 2.5), .user = i}));
    }
};

OccupancyMap small_map()
{
    CellTree cells;
    cells.set({{-8, -8, -8}, {8, 8, -6}}, CellState::occupied);
    cells.set({{0, 0, -6}, {2, 2, 3}}, CellState::occupied);
    cells.set({{-8, -8, -6}, {-3, 8, 8}}, CellState::free);
    return MapAccess::make("map", std::move(cells), 0.25);
}

/// Applies the same changes to a World's map and to a separate map.
class Changes {
public:
    explicit Changes(std::uint64_t seed) : random_(seed) {}

    void change(World& world, ModelId id, OccupancyMap& map)
    {
        const auto both = [&](auto make) {
            bool refused = false;
            try {
                make(map);
            } catch (const Error&) {
                refused = true; // no cell would remain occupied
            }
            return refused;
        };
        const Aabb box = this->box();
        const auto state = CellState(random_() % 3);
        bool refused = false, refused_here = false;
        try {
            switch (random_() % 4) {
            case 0: {
                std::vector<Vector3d> points;
                for (int i = 0; i < 5; ++i) points.push_back(point());
                refused = both([&](OccupancyMap& m) { m.set(points, state); });
                world.models().edit(id, [&](OccupancyMap& m) { m.set(points, state); });
                break;
            }
            case 1:
                refused = both([&](OccupancyMap& m) { m.set(box, state); });
                world.models().edit(id, [&](OccupancyMap& m) { m.set(box, state); });
                break;
            case 2: {
                const OccupancyMap by = small_map();
                refused = both([&](OccupancyMap& m) { m.replace(box, by); });
                world.models().edit(id, [&](OccupancyMap& m) { m.replace(box, by); });
                break;
            }
            default: {
                std::vector<Vector3d> points;
                for (int i = 0; i < 20; ++i) points.push_back(point());
                const Vector3d origin = point();
                refused = both([&](OccupancyMap& m) { m.insert_scan(points, origin, 2); });
                world.models().edit(id, [&](OccupancyMap& m) { m.insert_scan(points, origin, 2); });
            }
            }
        } catch (const Error&) {
            refused_here = true;
        }
        EXPECT_EQ(refused, refused_here);
    }

private:
    double number() { return double(random_() % 1000) / 200 - 2.5; }
    Vector3d point() { return {number(), number(), number()}; }
    Aabb box()
    {
        Aabb box;
        box.add(point()), box.add(point());
        return box;
    }
    std::mt19937_64 random_;
};

void expect_like_fresh(const Settings& settings)
{
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
        OccupancyMap map = small_map();
        Place place(settings, map);
        const std::shared_ptr<const OccupancyMap> first = std::make_shared<OccupancyMap>(map);
        Changes changes(seed);
        for (int frame = 0; frame < 12; ++frame) {
            for (int i = 0; i < 2; ++i) changes.change(place.world, place.models[0], map);
            Place fresh(settings, map);
            ASSERT_EQ(outcome_of(place.world), outcome_of(fresh.world)) << "seed " << seed << ", frame " << frame;
            EXPECT_EQ(map_of(place.world, place.models[0]).bounds().min, map.bounds().min);
            EXPECT_EQ(map_of(place.world, place.models[0]).bounds().max, map.bounds().max);
            const auto hits = place.world.space().overlaps(PlacedModel{place.models[1], random_pose(seed + 100, 2)});
            const auto fresh_hits =
                fresh.world.space().overlaps(PlacedModel{fresh.models[1], random_pose(seed + 100, 2)});
            ASSERT_EQ(hits.size(), fresh_hits.size());
        }
        EXPECT_TRUE(place.world.bodies().contains(place.bodies[0])) << "ids stay";
    }
}

TEST(MapChanges, GiveWhatAWorldGivesThatHasTheChangedMap)
{
    expect_like_fresh({.exact = ExactLevel::predicates});
}

TEST(MapChanges, GiveItWithinAnError)
{
    expect_like_fresh({.max_error = 0.1, .bounding_volume = BoundingVolume::obb});
}

TEST(MapChanges, GiveItBySpheres)
{
    expect_like_fresh({.depth = 3});
}

TEST(MapChanges, GiveItInSolidModeAndWithAClearance)
{
    expect_like_fresh({.clearance = 0.2, .exact = ExactLevel::predicates, .mode = Mode::solid});
}

TEST(MapChanges, LeaveTheMapOfOthersAsItWas)
{
    const auto shared = std::make_shared<const Geometry>(Geometry{"map", small_map(), {}});
    World one, other;
    const ModelId a = one.models().add(shared), b = other.models().add(shared);
    one.models().edit(a, [&](OccupancyMap& m) { m.set(Aabb{{-3, -3, 1}, {3, 3, 2}}, CellState::occupied); });
    EXPECT_GT(map_of(one, a).count(), map_of(other, b).count());
    EXPECT_EQ(map_of(other, b).count(), small_map().count());
    EXPECT_EQ(map_of(one, a).bounds().max.z(), 2);
    one.models().edit(a, [&](OccupancyMap& m) { m.set(Aabb{{-3, -3, 1}, {3, 3, 2}}, CellState::free); });
    EXPECT_EQ(map_of(one, a).bounds().max, small_map().bounds().max) << "bounds shrink";
}

TEST(MapChanges, ThatMakeNoSenseChangeNothing)
{
    World world;
    const ModelId map = world.models().add(small_map()), ball = world.models().add(Shape(Sphere{1}));
    const auto refuses = [&](auto work, const char* part) {
        try {
            work();
            FAIL() << "accepted";
        } catch (const Error& error) {
            EXPECT_EQ(error.kind(), ErrorKind::usage);
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    };
    const Aabb everything{Vector3d::Constant(-1e9), Vector3d::Constant(1e9)};
    const std::vector<Vector3d> near{{0, 0, 0}}, beyond{{0, 0, 0}, {1e6, 0, 0}}, nowhere{{std::nan(""), 0, 0}};
    EXPECT_THROW(world.models().edit(map,
                                     [](OccupancyMap& m) {
                                         m.set(Aabb{{0, 0, 4}, {1, 1, 5}}, CellState::occupied);
                                         throw std::runtime_error("of the caller");
                                     }),
                 std::runtime_error);
    EXPECT_GT(map_of(world, map).count(), small_map().count()) << "the cells stay set";
    world.models().edit(map, [](OccupancyMap& m) { m.set(Aabb{{0, 0, 4}, {1, 1, 5}}, CellState::free); });
    refuses([&] { world.models().edit(ball, [&](OccupancyMap& m) { m.set(near, CellState::free); }); },
            "is not an occupancy map");
    refuses([&] { world.models().edit(map, [&](OccupancyMap& m) { m.set(beyond, CellState::occupied); }); },
            "beyond the map's grid");
    refuses([&] { world.models().edit(map, [&](OccupancyMap& m) { m.set(nowhere, CellState::occupied); }); },
            "beyond the map's grid");
    refuses([&] { world.models().edit(map, [&](OccupancyMap& m) { m.set(everything, CellState::free); }); },
            "no cell would be left occupied");
    refuses(
        [&] {
            world.models().edit(map, [&](OccupancyMap& m) { m.replace(everything, make_building_map(1, 1.0, 1)); });
        },
        "resolution of 1 m");
    refuses([&] { world.models().edit(map, [&](OccupancyMap& m) { m.insert_scan(near, beyond[1]); }); },
            "beyond the map's grid");
    EXPECT_EQ(map_of(world, map).count(), small_map().count());
    world.models().edit(map, [&](OccupancyMap& m) {
        m.set(Aabb{{5, 5, 5}, {5.1, 5.1, 5.1}}, CellState::occupied);
    }); // it contains no centre of a cell
    EXPECT_EQ(map_of(world, map).count(), small_map().count());
}

TEST(MapChanges, ThatAreRefusedLeaveTheAnswersAsTheyWere)
{
    Place place({.exact = ExactLevel::predicates}, small_map());
    const Aabb everything{Vector3d::Constant(-1e9), Vector3d::Constant(1e9)};
    for (int round = 0; round < 5; ++round) {
        const std::vector<Vector3d> cell{{0.3 * round, 1.1, 0.6}};
        place.world.models().edit(place.models[0], [&](OccupancyMap& m) { m.set(cell, CellState::occupied); });
        const Outcome before = outcome_of(place.world);
        EXPECT_FALSE(before.empty());
        EXPECT_THROW(
            place.world.models().edit(place.models[0], [&](OccupancyMap& m) { m.set(everything, CellState::unknown); }),
            Error);
        EXPECT_EQ(outcome_of(place.world), before);
    }
}

} // namespace
} // namespace oncollide
