#include <oncollide/samples/catalogue.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <oncollide/base/text/near_word.hpp>
#include <oncollide/samples/catalogue_scenes.hpp>

namespace oncollide {

namespace {

struct Maker {
    const char* name;
    const char* summary;
    int default_bodies; ///< 0: constant for the scene
    int most_bodies;
    int frames;
    void (*make)(SceneBuilder&, const CatalogueOptions&);
    /// The number of bodies is limited only by the range of body numbers if a sink takes the bodies: each body follows
    /// from its index, and their geometries are few.
    bool endless = false;
};

constexpr Maker makers[] = {
    {"paper", "a bunny winds past a dragon, a cow and a lamp: the paper's scene, 1,500 triangles each", 0, 0, 2400,
     make_paper_scene},
    {"paper-5k", "the same with 5,100 triangles each", 0, 0, 2400, make_paper_5k_scene},
    {"many", "bunnies, dragons and cows drift and turn in a cube", 1000, 1'000'000, 100, make_many_scene, true},
    {"boxes", "boxes of all sizes on a random walk: the broad phase alone", 1000, 2'000'000, 60, make_boxes_scene},
    {"city", "traffic and drones between the static buildings of a city on a terrain", 2021, 1'000'000, 600,
     make_city_scene},
    {"octomap", "shapes and meshes drift through a scanned building", 12, 100'000, 200, make_octomap_scene},
    {"hills", "shapes and meshes drift low over a terrain of 320,000 triangles", 100, 100'000, 200, make_hills_scene},
    {"avalanche", "bodies of all shapes and concave meshes fall onto a steep hill, and go down it", 1050, 100'000, 250,
     make_avalanche_scene},
    {"flags", "flags that deform wave in the wind, and reach statues and balls", 160, 100'000, 300, make_flags_scene,
     true},
    {"campus", "shapes and meshes drift through a campus scanned at 20 cm, 1.09 million cells", 500, 100'000, 100,
     make_campus_scene},
    {"st-helens", "cars, lorries and drones on and above Mount St. Helens, 9.6 x 13.8 km; the DEM needs GDAL", 1000,
     100'000, 600, make_st_helens_scene},
    {"chunks", "2,000 balls over a game's ground of 16,384 static meshes of 578 triangles", 18'384, 100'000, 100,
     make_chunks_scene},
    {"tiles",
     "convoys of 2,000 vehicles over 10,000 tiles of ground, 101 million triangles; with --cache read from disk",
     12'000, 100'000, 300, make_tiles_scene},
    {"swarm", "ten million balls, of which one in a hundred moves", 10'000'000, 10'000'000, 20, make_swarm_scene, true},
    {"hard", "touching, coplanar, nested, tiny, huge and far: cases that collision detection gets wrong", 0, 0, 60,
     make_hard_scene},
    {"random", "every kind of geometry, drawn by lot: another seed is another scene", 20, 100'000, 20,
     make_random_scene},
};

[[noreturn]] void refuse(const std::string& what)
{
    throw Error(ErrorKind::usage, what);
}

const Maker& find_maker(const std::string& name)
{
    std::vector<std::string_view> names;
    for (const Maker& maker : makers) {
        if (name == maker.name) return maker;
        names.push_back(maker.name);
    }
    refuse(fmt::format("no scene named '{}' in the catalogue{}", name, valid_names(name, names, "it has")));
}

void make(const std::string& name, const CatalogueOptions& options, SceneInfo& info, SceneBuilder scene)
{
    constexpr int most_frames = 1'000'000'000;
    const Maker& maker = find_maker(name);
    if (options.bodies && maker.default_bodies == 0)
        refuse(fmt::format("scene {}: its number of bodies is fixed, {} is not possible", name, *options.bodies));
    const int most_bodies = scene.has_sink() && maker.endless ? 2'000'000'000 : maker.most_bodies;
    if (options.bodies && (*options.bodies < 1 || *options.bodies > most_bodies))
        refuse(fmt::format("scene {}: {} bodies, must be from 1 to {}", name, *options.bodies, most_bodies));
    if (options.frames && (*options.frames < 1 || *options.frames > most_frames))
        refuse(fmt::format("scene {}: {} frames, must be from 1 to {}", name, *options.frames, most_frames));

    CatalogueOptions complete = options;
    if (maker.default_bodies) complete.bodies = options.bodies.value_or(maker.default_bodies);
    complete.frames = options.frames.value_or(maker.frames);
    maker.make(scene, complete);
    info.name = name;
    info.frames = *complete.frames;
}

} // namespace

const std::vector<CatalogueEntry>& catalogue()
{
    static const std::vector<CatalogueEntry> entries = [] {
        std::vector<CatalogueEntry> list;
        for (const Maker& maker : makers) list.push_back({maker.name, maker.summary});
        return list;
    }();
    return entries;
}

Scene make_scene(const std::string& name, const CatalogueOptions& options)
{
    Scene scene;
    make(name, options, scene, scene);
    return scene;
}

SceneInfo make_scene(const std::string& name, BodySink& sink, const CatalogueOptions& options)
{
    SceneInfo info;
    make(name, options, info, {info, sink});
    return info;
}

Eigen::Vector3d Dice::within(const Eigen::Vector3d& half)
{
    Eigen::Vector3d v;
    for (int axis = 0; axis < 3; ++axis) v[axis] = half[axis] * (2 * next() - 1);
    return v;
}

Eigen::Vector3d Dice::direction()
{
    const double z = between(-1, 1), turn = between(0, 2 * std::numbers::pi),
                 ring = std::sqrt(std::max(0.0, 1 - z * z));
    return {ring * std::cos(turn), ring * std::sin(turn), z};
}

/// Source: Shoemake, "Uniform random rotations", Graphics Gems III, 1992.
Eigen::Quaterniond Dice::rotation()
{
    const double u = next(), a = between(0, 2 * std::numbers::pi), b = between(0, 2 * std::numbers::pi);
    const double p = std::sqrt(1 - u), q = std::sqrt(u);
    return Eigen::Quaterniond(q * std::cos(b), p * std::sin(a), p * std::cos(a), q * std::sin(b)).normalized();
}

Eigen::Isometry3d placed(const Eigen::Vector3d& position, const Eigen::Quaterniond& rotation)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = rotation.toRotationMatrix();
    pose.translation() = position;
    return pose;
}

GeometryId add_knot(SceneBuilder& scene, const std::string& name, double diagonal, int triangles)
{
    return add_geometry(scene, name,
                        {{"mesh",
                          {{"generate",
                            {{"kind", "torus_knot"},
                             {"p", 2},
                             {"q", 3},
                             {"major", 1},
                             {"minor", 0.4},
                             {"tube", 0.2},
                             {"triangles", triangles}}},
                           {"fit_diagonal", diagonal},
                           {"centre", true}}}});
}

GeometryId add_drone(SceneBuilder& scene)
{
    return add_knot(scene, "drone", 3, 1200);
}

GeometryId add_model(SceneBuilder& scene, const CatalogueOptions& options, const std::string& name,
                     const std::string& file, const Json& generator)
{
    Json mesh = {{"fit_diagonal", 2}, {"centre", true}};
    const std::filesystem::path path = options.data / "meshes" / "paper" / file;
    std::error_code ignored;
    if (!options.data.empty() && std::filesystem::is_regular_file(path, ignored)) {
        mesh["file"] = path.string();
    } else {
        mesh["generate"] = generator;
        scene.warnings().push_back(
            fmt::format("{}: no data folder with meshes/paper/{}; uses a generated mesh instead", name, file));
    }
    return add_geometry(scene, name, {{"mesh", std::move(mesh)}});
}

} // namespace oncollide
