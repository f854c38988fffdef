// Meshes and scenes of the tests of cooked files.
#pragma once
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

#include "cooked_bytes.hpp"
#include "scenes/test_files.hpp"

namespace oncollide::cooked_scenes {

namespace fs = std::filesystem;
using test::TemporaryFolder;

inline std::string read(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// The mesh has vertices that no triangle uses, duplicate triangles, and triangles without area.
inline Mesh odd_mesh(std::size_t triangles)
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> all;
    for (std::uint64_t i = 0; i < triangles; ++i) {
        const Eigen::Vector3d at(4 * u01(5, i, 0), 4 * u01(5, i, 1), u01(5, i, 2));
        for (std::uint64_t k = 0; k < 4; ++k)
            vertices.push_back(at +
                               0.1 * Eigen::Vector3d(u01(6, i, 3 * k), u01(6, i, 3 * k + 1), u01(6, i, 3 * k + 2)));
        const auto v = static_cast<std::uint32_t>(4 * i);
        all.push_back({v, v + 1, v + 2});
        if (i % 7 == 0) all.push_back({v + 1, v + 2, v});
        if (i % 11 == 0) all.push_back({v, v, v + 1});
    }
    return make_mesh("odd", std::move(vertices), std::move(all));
}

inline Mesh in_floats(const Mesh& mesh)
{
    std::vector<Eigen::Vector3d> vertices;
    for (const Eigen::Vector3d& v : mesh.vertices) vertices.push_back(v.cast<float>().cast<double>());
    return make_mesh("floats", std::move(vertices), mesh.triangles);
}

struct Sample {
    const char* name;
    Mesh mesh;
};

/// From one triangle to more than the size from which trees use grids (the terrain), of one chunk and of many.
inline const std::vector<Sample>& samples()
{
    static const std::vector<Sample> all{
        {"one triangle", make_mesh("one", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5}}, {{0, 1, 2}})},
        {"box", make_box_mesh({0.5, 0.4, 0.3})},
        {"odd", odd_mesh(400)},
        {"many odd", odd_mesh(12'000)},
        {"knot", make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.1, 30'000)},
        {"terrain", in_floats(make_terrain_mesh(20, 2, 300, 3))},
    };
    return all;
}

inline fs::path cooked(const TemporaryFolder& folder, const Mesh& mesh, const std::string& name = "mesh")
{
    const fs::path file = folder.path() / (name + ".cooked");
    cook_mesh(mesh, file);
    return file;
}

inline std::shared_ptr<const CookedMesh> opened(const fs::path& file)
{
    return std::make_shared<const CookedMesh>(file);
}

/// Bodies of the sample's mesh and a few others, which move through each other and apart.
inline Scene scene_of(const GeometryData& mesh, double size, bool turning)
{
    Scene scene;
    const GeometryId one = scene.add("one", mesh);
    const GeometryId ball = scene.add("ball", Shape(Sphere{0.2 * size})),
                     crate = scene.add("crate", Shape(Box{{0.1 * size, 0.2 * size, 0.1 * size}}));
    const GeometryId knot = scene.add("knot", make_torus_knot_mesh(2, 3, 0.2 * size, 0.1 * size, 0.05 * size, 600));
    scene.add_body({.name = "ground", .geometry = one, .is_static = true});
    std::uint64_t i = 0;
    for (const GeometryId geometry : {one, ball, crate, knot, ball, knot, crate, one}) {
        ++i;
        Drift drift;
        drift.velocity =
            size * (Eigen::Vector3d(u01(1, i, 0), u01(1, i, 1), u01(1, i, 2)) - Eigen::Vector3d::Constant(0.5)) * 0.3;
        if (turning) drift.spin = {0.3, 0.2 * double(i % 3), 0.1};
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() =
            size * (Eigen::Vector3d(u01(2, i, 0), u01(2, i, 1), u01(2, i, 2)) - Eigen::Vector3d::Constant(0.5));
        scene.add_body({.name = fmt::format("body {}", i), .geometry = geometry, .pose = pose, .motion = drift});
    }
    return scene;
}

struct Played {
    std::vector<std::vector<PairResult>> frames;
    std::uint64_t hash = 0;
    std::vector<std::string> faults;
    std::size_t bytes = 0;
};

inline Played play(Scene scene, const Settings& settings, int frames = 4)
{
    Played played;
    Pipeline pipeline(scene, settings);
    Mover mover;
    for (int frame = 0; frame < frames; ++frame) {
        mover.move(scene, frame);
        const FrameView view = pipeline.step(scene);
        played.frames.emplace_back(view.pairs.begin(), view.pairs.end());
        played.bytes = std::max(played.bytes, view.trees.bytes);
    }
    played.hash = pipeline.hash(), played.faults = pipeline.world().inspect().file_faults;
    return played;
}

inline void expect_same(const Played& a, const Played& b)
{
    EXPECT_EQ(a.hash, b.hash);
    ASSERT_EQ(a.frames.size(), b.frames.size());
    for (std::size_t f = 0; f < a.frames.size(); ++f) {
        ASSERT_EQ(a.frames[f].size(), b.frames[f].size()) << "frame " << f;
        for (std::size_t i = 0; i < a.frames[f].size(); ++i) {
            const PairResult &x = a.frames[f][i], &y = b.frames[f][i];
            EXPECT_TRUE(index(x.a) == index(y.a) && index(x.b) == index(y.b) && x.verdict == y.verdict &&
                        x.kind == y.kind && x.bound == y.bound)
                << "frame " << f << ", pair " << x.a.slot << " " << x.b.slot << ": " << int(x.verdict) << " " << x.bound
                << ", cooked " << int(y.verdict) << " " << y.bound;
        }
    }
}

/// A small body over one position of the terrain.
inline Scene one_body_on(const GeometryData& ground, const Eigen::Vector3d& at = {0, 0, 0})
{
    Scene scene;
    scene.add_body({.name = "ground", .geometry = scene.add("ground", ground), .is_static = true});
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = at;
    scene.add_body({.name = "crate", .geometry = scene.add("crate", make_box_mesh({0.2, 0.2, 5})), .pose = pose});
    return scene;
}

} // namespace oncollide::cooked_scenes
