// Arrangements in which some quantity is exactly zero, nearly zero, or of a very different size. Each group of bodies
// is a separate case, 20 m along x from the next.
#include <fmt/format.h>

#include <oncollide/samples/catalogue_scenes.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

class HardScene {
public:
    HardScene(SceneBuilder& scene, std::uint64_t seed) : scene_(scene), seed_(seed) {}

    /// Moves the origin of the next groups.
    void next_group() { origin_.x() += 20; }
    void go_to(const Vector3d& origin) { origin_ = origin; }

    void put(const std::string& name, GeometryId geometry, const Vector3d& offset,
             const Eigen::Quaterniond& rotation = Eigen::Quaterniond::Identity())
    {
        scene_.add_body({.name = name, .geometry = geometry, .pose = placed(origin_ + offset, rotation)});
    }

    GeometryId generated(const char* name, Json generator)
    {
        return add_geometry(scene_, name, {{"mesh", {{"generate", std::move(generator)}}}});
    }

    GeometryId listed(const char* name, Json vertices, Json triangles)
    {
        return add_geometry(scene_, name,
                            {{"mesh", {{"vertices", std::move(vertices)}, {"triangles", std::move(triangles)}}}});
    }

    void touching_boxes();
    void coplanar_walls();
    void same_place();
    void thin_triangles();
    void lone_triangles();
    void parallel_plates();
    void nested_spheres();
    void tiny_and_huge();
    void terrain_and_soup();
    void far_away();
    void slider();

private:
    SceneBuilder& scene_;
    std::uint64_t seed_;
    Vector3d origin_ = Vector3d::Zero();
    GeometryId cube_{}, ring_{};
};

/// Unit cubes that share a face, an edge or a corner, and a pair one ulp apart; as meshes and as shapes.
void HardScene::touching_boxes()
{
    cube_ = generated("cube", {{"kind", "box"}, {"half", {0.5, 0.5, 0.5}}});
    const GeometryId solid = scene_.add("solid-cube", Box{Vector3d::Constant(0.5)});
    for (const auto& [name, geometry] : {std::pair("mesh", cube_), std::pair("shape", solid)}) {
        put(fmt::format("touch-{}", name), geometry, {0, 0, 0});
        put(fmt::format("touch-{}-face", name), geometry, {1, 0, 0});
        put(fmt::format("touch-{}-edge", name), geometry, {-1, 1, 0});
        put(fmt::format("touch-{}-corner", name), geometry, {-1, -1, 1});
        put(fmt::format("touch-{}-almost", name), geometry, {0, 0, -1 - 0x1p-52});
        next_group();
    }
}

/// Two walls whose faces are coplanar and overlap, and a third, rotated by 90 degrees.
void HardScene::coplanar_walls()
{
    const GeometryId wall = generated("wall", {{"kind", "box"}, {"half", {2, 0.125, 1}}});
    put("wall-a", wall, {0, 0, 0});
    put("wall-b", wall, {1.5, 0, 0.25});
    put("wall-c", wall, {-1.875, 2, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(2 * std::atan(1.0), Vector3d::UnitZ())));
    next_group();
}

/// The same mesh twice at the same pose, and a third one ulp away.
void HardScene::same_place()
{
    ring_ = generated("ring", {{"kind", "torus"}, {"major", 1}, {"minor", 0.25}, {"triangles", 800}});
    const Eigen::Quaterniond rotated = Dice(seed_, 0).rotation();
    put("twin-a", ring_, {0, 0, 0}, rotated);
    put("twin-b", ring_, {0, 0, 0}, rotated);
    put("twin-c", ring_, {0x1p-40, 0, 0}, rotated);
    next_group();
}

/// Slivers, triangles without area, and needles that pass between samples.
void HardScene::thin_triangles()
{
    const GeometryId slivers =
        listed("slivers", {{-1, 0, 0}, {1, 0, 0}, {0, 1e-9, 0}, {0, 0, 1e-12}, {0.5, 0, 0}, {0, 1, 1}},
               {{0, 1, 2}, {0, 1, 3}, {0, 4, 1}, {5, 5, 5}, {0, 5, 2}});
    put("slivers-a", slivers, {0, 0, 0});
    put("slivers-b", slivers, {0.25, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Vector3d::UnitZ())));
    const GeometryId needles = generated(
        "needles", {{"kind", "needles"}, {"count", 300}, {"length", 1}, {"aspect", 1e5}, {"size", 2}, {"seed", seed_}});
    put("needles-a", needles, {0, 5, 0});
    put("needles-b", needles, {0.5, 5, 0}, Dice(seed_, 1).rotation());
    next_group();
}

/// Meshes of one triangle: crossing, sharing a corner, coplanar, and in parallel planes.
void HardScene::lone_triangles()
{
    const GeometryId one = listed("triangle", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
    const Eigen::Quaterniond upright(Eigen::AngleAxisd(2 * std::atan(1.0), Vector3d::UnitX()));
    put("triangle", one, {0, 0, 0});
    put("triangle-crossing", one, {0.25, 0.25, -0.5}, upright);
    put("triangle-corner", one, {1, 0, 0});
    put("triangle-coplanar", one, {0.5, -0.25, 0});
    put("triangle-above", one, {0, 0, 1e-9});
    next_group();
}

/// Plates 1e-12 m apart, and one tilted by 1e-9 rad that crosses them.
void HardScene::parallel_plates()
{
    const GeometryId plate = listed("plate", {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}}, {{0, 1, 2}, {0, 2, 3}});
    put("plate-a", plate, {0, 0, 0});
    put("plate-b", plate, {0, 0, 1e-12});
    put("plate-tilted", plate, {0, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(1e-9, Vector3d::UnitY())));
    next_group();
}

/// Spheres inside spheres: the surfaces are apart, the solids are not.
void HardScene::nested_spheres()
{
    const GeometryId shell = generated("shell", {{"kind", "sphere"}, {"radius", 2}, {"triangles", 2048}});
    const GeometryId core = generated("core", {{"kind", "sphere"}, {"radius", 0.5}, {"triangles", 512}});
    put("shell", shell, {0, 0, 0});
    put("core", core, {0, 0, 0});
    put("kernel", scene_.add("kernel", Sphere{0.125}), {0, 0, 0});
    next_group();
}

/// Sizes of a micrometre and of a thousand kilometres in one scene.
void HardScene::tiny_and_huge()
{
    const GeometryId mite = generated("mite", {{"kind", "sphere"}, {"radius", 1e-6}, {"triangles", 512}});
    put("mite-a", mite, {0, 0, 0});
    put("mite-b", mite, {1.9e-6, 0, 0});
    put("mite-c", mite, {0, 2.1e-6, 0});
    const GeometryId planet = generated("planet", {{"kind", "sphere"}, {"radius", 1e6}, {"triangles", 2048}});
    put("planet", planet, {0, 0, -1e6 - 10}); // its north pole is a vertex, 10 m under this group
    put("mite-on-planet", mite, {0, 0, -10});
    put("cube-on-planet", cube_, {0, 0, -9.5});
    next_group();
}

void HardScene::terrain_and_soup()
{
    const GeometryId terrain =
        generated("terrain", {{"kind", "terrain"}, {"size", 16}, {"height", 2}, {"cells", 48}, {"seed", seed_}});
    const double top = bounds_of(scene_.geometries()[index(terrain)]).max.z();
    const auto& vertices = std::get<Mesh>(scene_.geometries()[index(terrain)].data).vertices;
    Vector3d peak = vertices.front();
    for (const Vector3d& v : vertices)
        if (v.z() == top) peak = v;
    put("terrain", terrain, {0, 0, 0});
    put("cube-on-peak", cube_, peak + Vector3d(0, 0, 0.5));
    next_group();
    const GeometryId soup =
        generated("soup", {{"kind", "soup"}, {"count", 400}, {"edge", 0.5}, {"size", 3}, {"seed", seed_}});
    put("soup-a", soup, {0, 0, 0});
    put("soup-b", soup, {1, 0.5, 0}, Dice(seed_, 2).rotation());
    next_group();
}

/// Two touching cubes and two linked rings a thousand kilometres out: the results must be the same as at the origin.
void HardScene::far_away()
{
    const Eigen::Quaterniond upright(Eigen::AngleAxisd(2 * std::atan(1.0), Vector3d::UnitX()));
    for (const double distance : {0.0, 1e6}) {
        if (distance > 0) go_to(Vector3d::Constant(distance));
        const std::string where = distance > 0 ? "far" : "near";
        put(where + "-cube-a", cube_, {0, 0, 0});
        put(where + "-cube-b", cube_, {1, 0.25, 0.25});
        put(where + "-ring-a", ring_, {0, 5, 0});
        put(where + "-ring-b", ring_, {1, 5, 0}, upright);
    }
}

/// A cube that slides along the top of the walls, face on face.
void HardScene::slider()
{
    scene_.add_body({.name = "slider",
                     .geometry = cube_,
                     .pose = placed({38, 0, 1.5}),
                     .motion = Drift{.velocity = {0.0625, 0, 0}, .spin = Vector3d::Zero(), .walls = {}}});
}

} // namespace

void make_hard_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    HardScene hard(scene, options.seed);
    hard.touching_boxes(); // x = 0 and 20
    hard.coplanar_walls(); // x = 40
    hard.same_place();
    hard.thin_triangles();
    hard.lone_triangles();
    hard.parallel_plates();
    hard.nested_spheres();
    hard.tiny_and_huge();
    hard.terrain_and_soup();
    hard.far_away();
    hard.slider();
}

} // namespace oncollide
