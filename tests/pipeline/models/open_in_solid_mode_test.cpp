// Solid mode refuses a mesh without an inside wherever it comes in, not only as a body.
#include <functional>
#include <map>

#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
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
    PlacedModel placed{around, Eigen::Isometry3d::Identity()}, inside{world.bodies().model(small), placed.pose};
    std::vector<PairOfModels> pairs{{inside, placed}};
    std::vector<PlacedModel> queries = std::vector<PlacedModel>(1, {.model = around});
    MovingModel moving{around, {}}, still{world.bodies().model(small), {}};
    std::vector<PairOf<MovingModel>> ways{{moving, still}};
    std::vector<double> numbers = std::vector<double>(1), rows{};
    std::vector<std::uint8_t> near = {0};

    std::map<std::string, std::function<void()>> all()
    {
        for (int i = 0; i < 16; ++i) rows.push_back(i % 5 == 0);
        const PairOfColumns columns{{{&around, 1}, rows}, {{&inside.model, 1}, rows}};
        return {
            {"decide", [&] { world.pairs().decide(small, placed); }},
            {"decide pairs", [&] { world.pairs().decide(pairs, *std::make_unique<std::vector<Finding>>(1)); }},
            {"decide columns",
             [this, columns] { world.pairs().decide(columns, *std::make_unique<std::vector<Finding>>(1)); }},
            {"distance", [&] { world.pairs().distance(placed, small); }},
            {"distances", [&] { world.pairs().distance(pairs, {}, *std::make_unique<std::vector<Distance>>(1)); }},
            {"distances of columns",
             [this, columns] { world.pairs().distance(columns, {}, *std::make_unique<std::vector<Distance>>(1)); }},
            {"distances to all", [&] { world.space().distances(queries[0], {}, {.cutoff = 1}); }},
            {"contacts", [&] { world.pairs().contacts(placed, small); }},
            {"contacts of pairs", [&] { world.pairs().contacts(pairs, *std::make_unique<Lists<Contact>>()); }},
            {"penetration", [&] { world.pairs().penetration(placed, small); }},
            {"penetrations", [&] { world.pairs().penetration(pairs, *std::make_unique<std::vector<Penetration>>(1)); }},
            {"manifold", [&] { world.pairs().manifold(placed, small); }},
            {"near_features", [&] { world.pairs().near_features(placed, small, 1); }},
            {"near", [&] { WorldAccess::near(world, pairs, numbers, near); }},
            {"sweep", [&] { world.pairs().sweep(moving, still); }},
            {"sweeps", [&] { world.pairs().sweep(ways, {}, *std::make_unique<std::vector<SweepResult>>(1)); }},
            {"clear_until", [&] { WorldAccess::clear_until(world, ways, numbers, numbers); }},
            {"query", [&] { world.space().overlaps(placed); }},
            {"queries", [&] { world.space().overlaps(queries, {}, *std::make_unique<Lists<QueryHit>>()); }},
            {"cast", [&] { world.space().cast(moving); }},
            {"cast_all", [&] { world.space().cast_all(moving); }},
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
            const BodyId small = world.bodies().add({.model = world.models().add(make_box_mesh({0.1, 0.1, 0.1}))});
            const ModelId around = world.models().add(mesh, "around");
            const std::string expected = error_of([&] { world.bodies().add({.model = around}); });
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
    const ModelId used = world.models().add(make_box_mesh({1, 1, 1})), unused = world.models().add(holed());
    const BodyId body = world.bodies().add({.model = used});
    EXPECT_THROW(world.models().replace(used, mixed()), Error);
    EXPECT_THROW(world.bodies().set_model(body, unused), Error);
    EXPECT_TRUE(world.models().closed(used));
    EXPECT_EQ(world.bodies().model(body), used);
}

} // namespace
} // namespace oncollide::open_in_solid_mode_test
