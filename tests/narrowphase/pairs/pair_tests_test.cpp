// The table of tests over pairs of kinds.
#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace {

/// One model of each kind, by kind, with its trees, which the store owns.
std::vector<Model*> one_of_each_kind(ModelStore& store)
{
    TerrainGrid grid{.columns = 4, .rows = 4};
    grid.spacing = {0.5, 0.5}, grid.origin = {-0.75, -0.75, 0};
    const std::vector<double> heights{0, 0.25, 0, 0.5, 0.25, 0.75, 0.25, 0, 0, 0.25, 0.5, 0.25, 0.5, 0, 0, 0.25};
    std::vector<Model*> models;
    for (GeometryData data : std::initializer_list<GeometryData>{
             make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.08, 200), make_terrain("hills", grid, heights),
             make_building_map(1, 0.5, 3), Shape(Box{{0.25, 0.5, 0.375}}), Shape(Capsule{0.25, 0.5}),
             Shape(HalfSpace{})}) {
        Model& model = store[store.add(std::make_shared<const Geometry>(Geometry{{}, std::move(data), {}}))];
        EXPECT_EQ(std::size_t(model.kind()), models.size());
        if (model.has_triangles()) store.obb_tree(model, 0);
        models.push_back(&model);
    }
    return models;
}

bool has_surface(const Model& model)
{
    return model.has_triangles() || model.kind() == Kind::terrain;
}

/// Calls visit(seed, a, b, pose of a, pose of b) for all pairs of models and all seeds.
template <class Visit>
void each_pair(const std::vector<Model*>& models, std::uint64_t seeds, Visit visit)
{
    for (std::uint64_t seed = 0; seed < seeds; ++seed)
        for (Model* a : models)
            for (Model* b : models) {
                SCOPED_TRACE(testing::Message() << int(a->kind()) << " " << int(b->kind()) << " at " << seed);
                visit(seed, a, b, random_pose(2 * seed, 0.5), random_pose(2 * seed + 1, 2.5));
            }
}

TEST(PairTests, HaveATestForAllPairsOfKinds)
{
    for (std::size_t a = 0; a < kind_count; ++a)
        for (std::size_t b = 0; b < kind_count; ++b) {
            SCOPED_TRACE(testing::Message() << a << " " << b);
            const PairTests& tests = tests_for(Kind(a), Kind(b));
            EXPECT_TRUE(tests.decide && tests.near && tests.distance && tests.contacts);
            EXPECT_EQ(tests.direct_distance != nullptr, tests.trees != TreesNeeded::always);
            EXPECT_EQ(tests.penetration == nullptr, Kind(a) == Kind::terrain && Kind(b) == Kind::terrain);
        }
}

TEST(PairTests, AgreeInBothOrders)
{
    const Settings settings;
    ModelStore store(settings, make_cpu_backend());
    const auto models = one_of_each_kind(store);
    PairWorker worker;
    int colliding = 0, separate = 0;
    each_pair(models, 12,
              [&](std::uint64_t, Model* a, Model* b, const Eigen::Isometry3d& pose_a, const Eigen::Isometry3d& pose_b) {
                  const PairTask task{0, a, b, &pose_a, &pose_b}, back = task.swapped();
                  const Finding found = tests_for(task).decide(worker, task, {}, nullptr);
                  EXPECT_EQ(found.verdict, tests_for(back).decide(worker, back, {}, nullptr).verdict);
                  ++(found.verdict == Verdict::colliding ? colliding : separate);

                  constexpr double far = std::numeric_limits<double>::infinity();
                  const Distance there = tests_for(task).distance(worker, task, {.cutoff = far}, false),
                                 again = tests_for(back).distance(worker, back, {.cutoff = far}, false);
                  EXPECT_NEAR(there.upper, again.upper, 1e-9);
                  EXPECT_EQ(there.lower > 0, found.verdict == Verdict::separate);
                  if (there.lower > 0) {
                      EXPECT_NEAR((there.point_a - there.point_b).norm(), there.upper, 1e-9);
                  }
                  std::vector<Contact> contacts, of_back;
                  tests_for(task).contacts(worker, task, contacts), tests_for(back).contacts(worker, back, of_back);
                  EXPECT_EQ(contacts.size(), of_back.size());
                  for (const Contact& c : contacts)
                      EXPECT_TRUE(std::ranges::any_of(
                          of_back, [&](const Contact& d) { return std::pair(d.b, d.a) == std::pair(c.a, c.b); }));
              });
    EXPECT_GT(colliding, 40);
    EXPECT_GT(separate, 40);
}

TEST(PairTests, GiveOneVerdictInBothOrdersWhereBodiesTouch)
{
    const Settings settings;
    ModelStore store(settings, make_cpu_backend());
    const auto models = one_of_each_kind(store);
    PairWorker worker;
    int colliding = 0, separate = 0;
    each_pair(models, 24,
              [&](std::uint64_t seed, Model* a, Model* b, const Eigen::Isometry3d& pose_a, Eigen::Isometry3d pose_b) {
                  const bool surfaces = has_surface(*a) && has_surface(*b),
                             polytopes = a->kind() == Kind::polytope && b->kind() == Kind::polytope;
                  if (surfaces && !polytopes) return; // they are exact for b's vertices rounded in a's frame
                  if (seed % 3 == 0) pose_b.linear() = pose_a.linear();
                  const PairTask task{0, a, b, &pose_a, &pose_b}, back = task.swapped();
                  const Distance apart = tests_for(task).distance(worker, task, {}, false);
                  pose_b.translation() += apart.point_a - apart.point_b;
                  for (const bool kinds : {false, true}) {
                      if (kinds && polytopes) continue; // the same, of their triangles
                      const Finding found = tests_for(task).decide(worker, task, {.kinds = kinds}, nullptr);
                      EXPECT_EQ(found, tests_for(back).decide(worker, back, {.kinds = kinds}, nullptr));
                      if (apart.lower > 0) ++(found.verdict == Verdict::separate ? separate : colliding);
                  }
              });
    EXPECT_GT(colliding, 50);
    EXPECT_GT(separate, 50);
}

/// A mesh with its vertices and triangles in another order.
Mesh reordered(const Mesh& mesh)
{
    const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
    const auto place = [&](std::uint32_t v) {
        return static_cast<std::uint32_t>((v * std::uint64_t{7919} + 3) % count);
    };
    std::vector<Eigen::Vector3d> vertices(count);
    for (std::uint32_t v = 0; v < count; ++v) vertices[place(v)] = mesh.vertices[v];
    std::vector<Triangle> triangles(mesh.triangles.rbegin(), mesh.triangles.rend());
    for (Triangle& t : triangles) t = {place(t[1]), place(t[2]), place(t[0])};
    return make_mesh("reordered", std::move(vertices), std::move(triangles));
}

/// A mesh that coincides with its copy has millions of pairs of triangles that only touch.
TEST(PairTests, DecideAMeshAgainstItsCopyByAFewTriangles)
{
    const Settings settings;
    ModelStore store(settings, make_cpu_backend());
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.08, 20'000);
    ASSERT_NE(knot.vertices.size() % 7919, 0u);
    std::vector<Model*> models;
    for (const Mesh& mesh : {knot, knot, reordered(knot)}) {
        models.push_back(&store[store.add(std::make_shared<const Geometry>(Geometry{{}, mesh, {}}))]);
        store.obb_tree(*models.back(), 0);
    }
    for (Model* other : models)
        for (const double by : {0.0, 1e-9})
            for (const Eigen::Isometry3d& pose : {Eigen::Isometry3d::Identity(), random_pose(1, 2)}) {
                PairWorker worker;
                const Eigen::Isometry3d moved = Eigen::Translation3d(by, 0, 0) * pose;
                const PairTask task{0, models[0], other, &pose, &moved};
                const Finding found = tests_for(task).decide(worker, task, {.kinds = true}, nullptr);
                EXPECT_EQ(found, Finding(Verdict::colliding, ContactKind::crossing, 0));
                EXPECT_LT(worker.counts().triangles, 2000u)
                    << "of " << 13 * knot.triangles.size() << ", moved by " << by;
            }
}

/// The copy of an open surface only touches it.
TEST(PairTests, FindThatAnOpenMeshTouchesItsCopy)
{
    const Settings settings;
    ModelStore store(settings, make_cpu_backend());
    Mesh open = make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.08, 2000);
    open.triangles.pop_back();
    std::vector<Model*> models;
    for (const Mesh& mesh : {open, reordered(open)}) {
        models.push_back(&store[store.add(std::make_shared<const Geometry>(Geometry{{}, mesh, {}}))]);
        store.obb_tree(*models.back(), 0);
    }
    const Eigen::Isometry3d pose = random_pose(1, 2);
    PairWorker worker;
    for (Model* other : models) {
        const PairTask task{0, models[0], other, &pose, &pose};
        EXPECT_EQ(tests_for(task).decide(worker, task, {.kinds = true}, nullptr),
                  Finding(Verdict::colliding, ContactKind::touching, 0));
    }
}

} // namespace
} // namespace oncollide
