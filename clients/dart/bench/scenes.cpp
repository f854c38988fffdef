#include "scenes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace dart::collision::oncollide_client::bench {

using dynamics::BodyNode;
using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

constexpr double degrees = 180 / std::numbers::pi;

Isometry3d at(double x, double y, double z)
{
    return Isometry3d(Eigen::Translation3d(x, y, z));
}

double tilt(const BodyNode* body)
{
    return degrees * std::acos(std::clamp(body->getTransform().linear()(2, 2), -1.0, 1.0));
}

dynamics::ShapePtr box_shape(const Vector3d& size)
{
    return std::make_shared<dynamics::BoxShape>(size);
}

// --- A stack of five boxes of 1 m.

Measures stack(int cuts, const std::string& detector, const Limits& limits, View& view)
{
    Run run(detector);
    run.add(tests::fixed(box_shape({10, 10, 1}), "ground", 1, at(0, 0, -0.5)));
    const dynamics::ShapePtr shape =
        cuts ? tests::mesh_shape(tests::box_mesh(Vector3d::Ones(), cuts)) : box_shape(Vector3d::Ones());
    std::vector<BodyNode*> boxes;
    for (int k = 0; k < 5; ++k)
        boxes.push_back(run.add(tests::free_body(shape, "box " + std::to_string(k), at(0, 0, k + 0.5), 1000,
                                                 Eigen::Matrix3d::Identity() * 1000 / 6)));
    std::vector<std::pair<double, std::vector<Vector3d>>> way; // times and positions
    double normal = 0, reported = 0, real = 0, most_tilt = 0;
    run.play(20, limits, [&] {
        way.emplace_back(run.time(), std::vector<Vector3d>());
        for (const BodyNode* box : boxes) {
            way.back().second.push_back(box->getTransform().translation());
            most_tilt = std::max(most_tilt, tilt(box));
        }
        for (int k = 0; k < 5; ++k)
            real = std::max(real, k + 1 - 0.5 - way.back().second[std::size_t(k)].z()); // sunk, against touching boxes
        for (const Contact& contact : run.contacts().getContacts()) {
            normal = std::max(normal, degrees * std::acos(std::min(1.0, std::abs(contact.normal.z()))));
            reported = std::max(reported, contact.penetrationDepth);
        }
    });
    const auto& [t0, from] = way[way.size() / 2];
    const auto& [t1, to] = way.back();
    double creep = 0;
    for (std::size_t k = 0; k < 5; ++k)
        creep = std::max(creep, (to[k] - from[k]).head<2>().norm() / std::max(t1 - t0, 1e-3));
    run.show(view);
    Measures found = run.common();
    found.insert(found.end(), {{"creep mm/s", 1e3 * creep},
                               {"tilt degrees", most_tilt},
                               {"normals off degrees", normal},
                               {"depth told mm", 1e3 * reported},
                               {"sunk mm", 1e3 * real}});
    return found;
}

// --- A mesh box that slides without friction over a plane of triangles.

Measures slide(int cuts, const std::string& detector, const Limits& limits, View& view)
{
    Run run(detector);
    oncollide::Mesh ground = tests::box_mesh({20, 20, 1}, cuts);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> shift(-6.0 / cuts, 6.0 / cuts);
    for (Vector3d& v : ground.vertices) // an irregular triangulation of the same plane
        if (v.z() > 0 && v.head<2>().cwiseAbs().maxCoeff() < 9.99) v.x() += shift(random), v.y() += shift(random);
    run.add(tests::fixed(tests::mesh_shape(ground), "ground", 0, at(0, 0, -0.5)));
    Isometry3d start = at(-4, -1, 0.2499); // a tenth of a millimetre deep
    start.rotate(Eigen::AngleAxisd(0.3, Vector3d::UnitZ()));
    BodyNode* box = run.add(tests::free_body(tests::mesh_shape(tests::box_mesh(Vector3d::Constant(0.5), 4)), "box",
                                             start, 125, Eigen::Matrix3d::Identity() * 125 / 24, 0));
    const Vector3d along = Vector3d(1, 0.2, 0).normalized();
    static_cast<dynamics::FreeJoint*>(box->getParentJoint())->setLinearVelocity(2 * along);
    double sideways = 0, up = 0, speed = 0, most_tilt = 0;
    run.play(3, limits, [&] {
        const Vector3d v = box->getLinearVelocity();
        sideways = std::max(sideways, std::abs(v.dot(Vector3d(-along.y(), along.x(), 0))));
        up = std::max(up, v.z()), speed = std::max(speed, std::abs(v.dot(along) / 2 - 1));
        most_tilt = std::max(most_tilt, tilt(box));
    });
    run.show(view), view.see(start.translation());
    Measures found = run.common();
    found.insert(
        found.end(),
        {{"sideways mm/s", 1e3 * sideways}, {"up mm/s", 1e3 * up}, {"speed off", speed}, {"tilt degrees", most_tilt}});
    return found;
}

// --- One body inside a mesh.

Measures enclosed(bool mesh, const std::string& detector, const Limits&, View& view)
{
    Clock clock;
    const auto made = make_detector(detector, clock);
    const auto frame = [](const dynamics::ShapePtr& shape) {
        auto simple = dynamics::SimpleFrame::createShared(dynamics::Frame::World());
        simple->setShape(shape);
        return simple;
    };
    const auto outer = frame(tests::mesh_shape(tests::box_mesh(Vector3d::Constant(2), 4)));
    const auto inner = frame(mesh ? tests::mesh_shape(tests::box_mesh(Vector3d::Constant(0.4), 2))
                                  : box_shape(Vector3d::Constant(0.4)));
    const auto group = made->createCollisionGroup(outer.get(), inner.get());
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> place(-0.75, 0.75);
    int seen = 0, right = 0;
    constexpr int tries = 100;
    for (int i = 0; i < tries; ++i) {
        const Vector3d p(place(random), place(random), place(random));
        inner->setTranslation(p);
        CollisionResult result;
        if (!group->collide(CollisionOption(true, 1000, nullptr), &result)) continue;
        ++seen;
        int axis = 0;
        p.cwiseAbs().maxCoeff(&axis); // out through the nearest side
        const Vector3d out = (p[axis] < 0 ? -1.0 : 1.0) * Vector3d::Unit(axis);
        const Contact& contact = result.getContact(0);
        const double sign = contact.collisionObject1->getShapeFrame() == outer.get() ? -1 : 1;
        right += sign * contact.normal.dot(out) > 0.999 && contact.penetrationDepth > 0;
    }
    CollisionResult result;
    inner->setTranslation({0.6, -0.2, 0.1});
    group->collide(CollisionOption(true, 1000, nullptr), &result);
    view.add(*outer->getShape(), outer->getTransform(), View::Role::glass);
    view.add(*inner->getShape(), inner->getTransform(), View::Role::moving), view.add(result);
    return {{"seen %", 100.0 * seen / tries}, {"normal right %", 100.0 * right / tries}};
}

// --- A pile of concave meshes in a box; two of them in deep overlap.

Measures pile(const SolidMesh& body, double size, int count, const std::string& detector, const Limits& limits,
              View& view)
{
    Run run(detector);
    const double wall = 1.6 * size;
    run.add(tests::fixed(box_shape({8 * size, 8 * size, size}), "floor", 0.5, at(0, 0, -size / 2)));
    for (int k = 0; k < 4; ++k) {
        const double x = (k < 2 ? (k ? 1 : -1) : 0) * (wall + size / 2),
                     y = (k < 2 ? 0 : (k == 2 ? -1 : 1)) * (wall + size / 2);
        run.add(tests::fixed(box_shape({k < 2 ? size : 5 * size, k < 2 ? 5 * size : size, 12 * size}),
                             (k == 1 || k == 2 ? "front wall " : "wall ") + std::to_string(k), 0.5,
                             at(x, y, 6 * size)));
    }
    const dynamics::ShapePtr shape = tests::mesh_shape(body.mesh);
    std::mt19937_64 random(2);
    std::normal_distribution<double> normal;
    std::vector<BodyNode*> bodies;
    for (int i = 0; i < count; ++i) {
        Isometry3d pose =
            at((i % 2 ? 0.75 : -0.75) * size, (i / 2 % 2 ? 0.75 : -0.75) * size, (0.8 + 1.25 * (i / 4)) * size);
        pose.linear() =
            Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized().matrix();
        bodies.push_back(
            run.add(tests::free_body(shape, "body " + std::to_string(i), pose, body.mass, body.inertia, 0.5)));
    }
    Limits all = limits;
    all.budget *= 4; // to rest takes long
    run.play(4, all);
    double fastest = 0, lost = 0;
    for (const BodyNode* b : bodies) {
        fastest = std::max(fastest, b->getLinearVelocity().norm());
        const Vector3d p = b->getTransform().translation();
        lost += p.z() < 0 || std::abs(p.x()) > wall || std::abs(p.y()) > wall;
    }
    run.show(view);
    Measures found = run.common();
    found.insert(found.end(), {{"lost bodies", lost}, {"fastest at the end mm/s", 1e3 * fastest}});
    return found;
}

Measures overlap(const oncollide::Mesh& mesh, const std::string& detector, const Limits& limits, View& view)
{
    Clock clock;
    const auto made = make_detector(detector, clock);
    const auto a = dynamics::SimpleFrame::createShared(dynamics::Frame::World());
    const auto b = dynamics::SimpleFrame::createShared(dynamics::Frame::World());
    a->setShape(tests::mesh_shape(mesh)), b->setShape(tests::mesh_shape(mesh));
    b->setRotation(Eigen::AngleAxisd(0.5, Vector3d(1, 2, 3).normalized()).matrix());
    const auto group = made->createCollisionGroup(a.get(), b.get());
    CollisionResult result;
    const CollisionOption option(true, 1000, nullptr);
    group->collide(option, &result); // makes the trees
    clock = {};
    for (int i = 0; i < 20 && clock.seconds < limits.budget; ++i) {
        b->setTranslation({0.001 * i, 0, 0.1});
        made->collide(group.get(), option, &result);
    }
    for (const auto& frame : {a, b}) view.add(*frame->getShape(), frame->getTransform(), View::Role::moving);
    view.add(result);
    return {{"detection ms", 1e3 * clock.seconds / double(clock.calls)}, {"contacts", double(result.getNumContacts())}};
}

// --- A nut on its bolt.

/// The angle of the nut, where it is lifted by `lift`, at which it is farthest from the bolt.
double free_angle(const oncollide::Mesh& nut, const oncollide::Mesh& bolt, double lift)
{
    oncollide::World world;
    const auto of_nut = world.models().add(nut), of_bolt = world.models().add(bolt);
    double best = 0, farthest = -1;
    for (int i = 0; i < 720; ++i) {
        Isometry3d pose = at(0, 0, lift);
        pose.rotate(Eigen::AngleAxisd(i * std::numbers::pi / 360, Vector3d::UnitZ()));
        const double gap =
            world.pairs()
                .distance(oncollide::PlacedModel{of_nut, pose}, oncollide::PlacedModel{of_bolt}, {.tolerance = 1e-6})
                .lower;
        if (gap > farthest) farthest = gap, best = i * std::numbers::pi / 360;
    }
    return best;
}

struct NutAndBolt {
    oncollide::Mesh nut, bolt; ///< the nut around its own centre
    double height;             ///< of that centre
    double angle;              ///< at which it is free of the bolt
};

Measures nut(const NutAndBolt& parts, double friction, const std::string& detector, const Limits& limits, View& view)
{
    Run run(detector);
    run.add(tests::fixed(tests::mesh_shape(parts.bolt), "bolt", friction));
    Isometry3d start = at(0, 0, parts.height);
    start.rotate(Eigen::AngleAxisd(parts.angle, Vector3d::UnitZ()));
    constexpr double mass = 0.03, across = 0.024, tall = 0.013; // of a hollow cylinder, nearly
    const double around = mass * (0.008 * 0.008 + across * across / 4) / 2, over = around / 2 + mass * tall * tall / 12;
    BodyNode* body = run.add(tests::free_body(tests::mesh_shape(parts.nut), "nut", start, mass,
                                              Vector3d(over, over, around).asDiagonal(), friction));
    double turned = 0, most_tilt = 0, depth = 0, last = 0, from_turned = 0, from_z = 0;
    const double simulated = friction > 0 ? 1 : 60;
    const double turns = 5;
    Limits step = limits;
    step.scale = 1, step.budget *= 4; // five turns are long
    bool begun = false;
    const auto look = [&] {
        const Eigen::Matrix3d r = body->getTransform().linear() * start.linear().transpose();
        const double now = std::atan2(r(1, 0) - r(0, 1), r(0, 0) + r(1, 1));
        turned += std::remainder(now - last, 2 * std::numbers::pi), last = now;
        most_tilt = std::max(most_tilt, tilt(body));
        for (const Contact& contact : run.contacts().getContacts()) depth = std::max(depth, contact.penetrationDepth);
        if (!begun && std::abs(turned) > std::numbers::pi)
            begun = true, from_turned = turned, from_z = body->getTransform().translation().z();
    };
    for (double t = 0; t < simulated * limits.scale && std::abs(turned) < turns * 2 * std::numbers::pi; t += 0.01) {
        const double before = run.time();
        run.play(0.01, step, look);
        if (run.time() == before) break; // the budget is used up
    }
    const double round = std::abs(turned - from_turned) / (2 * std::numbers::pi);
    run.show(view), view.see(start.translation()), view.see(start.translation() - Vector3d(0, 0, 0.03));
    Measures found = run.common();
    found.insert(found.end(),
                 {{"turns", std::abs(turned) / (2 * std::numbers::pi)},
                  {"mm per turn", begun && round > 0.1 ? 1e3 * (from_z - body->getTransform().translation().z()) / round
                                                       : std::nan("")},
                  {"tilt degrees", most_tilt},
                  {"depth told mm", 1e3 * depth}});
    return found;
}

} // namespace

std::vector<SceneRun> all_scenes(const std::filesystem::path& data)
{
    std::vector<SceneRun> scenes;
    const auto add = [&](std::string scene, std::string variant, auto run) {
        scenes.push_back({std::move(scene), std::move(variant), std::move(run)});
    };
    for (const auto& [cuts, name] :
         {std::pair(0, "boxes"), std::pair(1, "12 triangles"), std::pair(10, "1,200 triangles")})
        add("stack", name, [cuts = cuts](const auto& d, const auto& l, View& v) { return stack(cuts, d, l, v); });
    for (const auto& [cuts, name] :
         {std::pair(3, "108 triangles"), std::pair(41, "20,172 triangles"), std::pair(129, "199,692 triangles")})
        add("slide", name, [cuts = cuts](const auto& d, const auto& l, View& v) { return slide(cuts, d, l, v); });
    for (const bool mesh : {true, false})
        add("enclosed", mesh ? "mesh in mesh" : "box in mesh",
            [mesh](const auto& d, const auto& l, View& v) { return enclosed(mesh, d, l, v); });
    const SolidMesh knot = solid(oncollide::make_torus_knot_mesh(2, 3, 0.3, 0.12, 0.07, 600));
    add("pile", "20 knots", [knot](const auto& d, const auto& l, View& v) { return pile(knot, 0.7, 20, d, l, v); });
    if (const auto file = data / "meshes/paper/cow.obj"; exists(file)) {
        const SolidMesh cow = solid(oncollide::load_mesh(file));
        add("pile", "20 cows", [cow](const auto& d, const auto& l, View& v) { return pile(cow, 0.9, 20, d, l, v); });
    }
    const oncollide::Mesh large = oncollide::make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.15, 5000);
    add("overlap", "two knots of 5,000",
        [large](const auto& d, const auto& l, View& v) { return overlap(large, d, l, v); });
    const auto bolt = data / "contacts/factory_bolt_m16_loose.obj",
               nut_file = data / "contacts/factory_nut_m16_loose_subdiv_3x.obj";
    if (exists(bolt) && exists(nut_file)) {
        NutAndBolt parts{oncollide::load_mesh(nut_file), oncollide::load_mesh(bolt), 0, 0};
        const double middle = parts.nut.bounds.centre().z();
        for (Vector3d& v : parts.nut.vertices) v.z() -= middle;
        parts.nut = oncollide::make_mesh("nut", parts.nut.vertices, parts.nut.triangles);
        parts.height = middle + 0.012; // at the upper end of the thread, six turns above its place in the file
        parts.angle = free_angle(parts.nut, parts.bolt, parts.height);
        for (const double friction : {0.0, 0.2})
            add("nut M16", friction > 0 ? "friction 0.2" : "no friction",
                [=](const auto& d, const auto& l, View& v) { return nut(parts, friction, d, l, v); });
    }
    return scenes;
}

} // namespace dart::collision::oncollide_client::bench
