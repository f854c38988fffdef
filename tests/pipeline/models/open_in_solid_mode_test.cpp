// Solid mode refuses a mesh without an inside wherever it comes in, not only as a body.
#include <functional>
#include <map>

#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::open_in_solid_mode_test {
namespace {

Mesh holed()
{
    Mesh mesh = make_box_mesh({1, 1, 1});
    mesh.triangles.pop_back();
    return mesh;
}

/// Half of the faces are turned over.
Mesh mixed()
{
    Mesh mesh = make_box_mesh({1, 1, 1});
    for (std::size_t i = 6; i < 12; ++i) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
    return mesh;
}

/// Every call that takes a model, of a mesh around a small box.
struct Calls {
    const World& world;
    ModelId around;
    BodyId small;
    PlacedModel placed{around, Eigen::Isometry3d::Identity()}, inside{world.model(small), placed.pose};
    std::vector<PairOfModels> pairs{{inside, placed}};
    std::vector<ModelQuery> queries = std::vector<ModelQuery>(1, {.model = around});
    MovingModel moving{around, {}}, still{world.model(small), {}};
    std::vector<PairOfMovingModels> ways{{moving, still}};
    std::vector<double> numbers = std::vector<double>(1), rows{};
    std::vector<std::uint8_t> near = {0};

    std::map<std::string, std::function<void()>> all()
    {
        for (int i = 0; i < 16; ++i) rows.push_back(i % 5 == 0);
        const ModelPairColumns columns{{&around, 1}, {&inside.model, 1}, rows, rows};
        return {
            {"decide", [&] { world.decide(small, placed); }},
            {"decide pairs", [&] { world.decide(pairs, *std::make_unique<std::vector<Finding>>(1)); }},
            {"decide columns",
             [this, columns] { world.decide(columns, *std::make_unique<std::vector<Verdict>>(1), numbers); }},
            {"distance", [&] { world.distance(placed, small); }},
            {"distances", [&] { world.distances(pairs, *std::make_unique<std::vector<Distance>>(1)); }},
            {"distances of columns",
             [this, columns] { world.distances(columns, *std::make_unique<std::vector<Distance>>(1)); }},
            {"distances to all", [&] { world.distances(queries[0], 1); }},
            {"contacts", [&] { world.contacts(placed, small); }},
            {"contacts of pairs", [&] { world.contacts(pairs, *std::make_unique<ContactLists>()); }},
            {"penetration", [&] { world.penetration(placed, small); }},
            {"penetrations", [&] { world.penetration(pairs, *std::make_unique<std::vector<Penetration>>(1)); }},
            {"manifold", [&] { world.manifold(placed, small); }},
            {"near", [&] { world.near(pairs, numbers, near); }},
            {"near bodies", [&] { world.near(queries, numbers, *std::make_unique<QueryHits>()); }},
            {"sweep", [&] { world.sweep(moving, still); }},
            {"sweeps", [&] { world.sweep(ways, *std::make_unique<std::vector<SweepResult>>(1)); }},
            {"clear_until", [&] { world.clear_until(ways, numbers, numbers); }},
            {"query", [&] { world.query(around, placed.pose); }},
            {"queries", [&] { world.query(queries, *std::make_unique<QueryHits>()); }},
            {"cast", [&] { world.cast(moving); }},
            {"cast_all", [&] { world.cast_all(moving); }},
        };
    }
};

std::string error_of(const std::function<void()>& call)
{
    try {
        call();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::bad_data);
        return error.what();
    }
    return "";
}

TEST(OpenInSolidMode, EveryQueryOfAModelRefusesWhatAddBodyRefuses)
{
    for (const bool as_surface : {false, true})
        for (const Mesh& mesh : {holed(), mixed(), make_box_mesh({1, 1, 1})}) {
            World world({.mode = Mode::solid, .open_as_surface = as_surface});
            const BodyId small = world.add_body({.model = world.add(make_box_mesh({0.1, 0.1, 0.1}))});
            const ModelId around = world.add(mesh, "around");
            const std::string expected = error_of([&] { world.add_body({.model = around}); });
            EXPECT_EQ(expected.empty(), as_surface || is_closed(mesh));
            Calls calls{world, around, small};
            for (const auto& [name, call] : calls.all()) {
                const std::string found = error_of(call);
                EXPECT_EQ(found.empty(), expected.empty()) << name;
                EXPECT_TRUE(found.ends_with(expected)) << name << ": " << found;
            }
        }
}

TEST(OpenInSolidMode, AModelInUseCannotBecomeOpen)
{
    World world({.mode = Mode::solid});
    const ModelId used = world.add(make_box_mesh({1, 1, 1})), unused = world.add(holed());
    const BodyId body = world.add_body({.model = used});
    EXPECT_THROW(world.replace(used, mixed()), Error);
    EXPECT_THROW(world.set_model(body, unused), Error);
    EXPECT_TRUE(world.closed(used));
    EXPECT_EQ(world.model(body), used);
}

} // namespace
} // namespace oncollide::open_in_solid_mode_test
