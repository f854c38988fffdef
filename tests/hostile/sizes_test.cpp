// Inputs that used to take time or memory out of proportion to their size. Each limit is far below the old value or
// the value of a quadratic algorithm, and far above the present value, for slow machines.
#include <chrono>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "scenes/test_files.hpp"
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/files/scene_file.hpp>

namespace oncollide {
namespace {

using Eigen::Vector2d;

class HostileSizes : public ::testing::Test {
protected:
    template <class Work>
    double seconds(Work work)
    {
        const auto start = std::chrono::steady_clock::now();
        work();
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    /// Triangulates the polygon `faces` times, and expects triangles that cover it once.
    double seconds_to_cut(const std::vector<Vector2d>& outline, int faces)
    {
        std::string text, face = "f";
        double twice_area = 0;
        for (std::size_t i = 0; i < outline.size(); ++i) {
            const Vector2d &p = outline[i], &q = outline[(i + 1) % outline.size()];
            twice_area += p.x() * q.y() - p.y() * q.x();
            text += fmt::format("v {} {} 0\n", p.x(), p.y());
            face += fmt::format(" {}", i + 1);
        }
        for (int k = 0; k < faces; ++k) text += face + "\n";
        const auto path = folder_.write("a.obj", text);
        Mesh mesh;
        const double time = seconds([&] { mesh = load_mesh(path); });
        EXPECT_EQ(mesh.triangles.size(), static_cast<std::size_t>(faces) * (outline.size() - 2));
        double sum = 0;
        for (const Triangle& t : mesh.triangles) {
            const Eigen::Vector3d& a = mesh.vertices[t[0]];
            sum += std::abs((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).z());
        }
        EXPECT_NEAR(sum, faces * std::abs(twice_area), 1e-6 * sum);
        return time;
    }
    test::TemporaryFolder folder_;
};

TEST_F(HostileSizes, ASpiralOf4096CornersIsCutInMilliseconds)
{
    constexpr int half = 2048;
    std::vector<Vector2d> spiral;
    const auto arm = [&](int i, double offset) {
        const double angle = 40 * std::numbers::pi * i / half;
        spiral.push_back((offset + angle) * Vector2d(std::cos(angle), std::sin(angle)));
    };
    for (int i = 0; i < half; ++i) arm(i, 1);
    for (int i = half - 1; i >= 0; --i) arm(i, 0.5);
    EXPECT_LT(seconds_to_cut(spiral, 20), 4) << "was 15 s and more";
}

TEST_F(HostileSizes, CombsAndStarsOf4096CornersAreCutInMilliseconds)
{
    std::vector<Vector2d> comb, star;
    for (int i = 0; i < 2047; ++i) comb.push_back({double(i), 0}), comb.push_back({i + 0.5, 100});
    comb.push_back({2047, -1}), comb.push_back({-1, -1});
    for (int i = 0; i < 4096; ++i) {
        const double angle = 2 * std::numbers::pi * i / 4096, radius = i % 2 ? 1 : 3;
        star.push_back(radius * Vector2d(std::cos(angle), std::sin(angle)));
    }
    EXPECT_LT(seconds_to_cut(comb, 20), 4);
    EXPECT_LT(seconds_to_cut(star, 20), 4);
}

TEST_F(HostileSizes, LoadingTimeIsLinearInGeometries)
{
    folder_.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 1\n");
    const auto seconds_of = [&](int count) {
        std::string geometries, bodies;
        for (int i = 0; i < count; ++i) {
            geometries += fmt::format("{}\"g{}\":{{\"mesh\":{{\"file\":\"t.obj\"}}}}", i ? "," : "", i);
            bodies += fmt::format("{}{{\"geometry\":\"g{}\"}}", i ? "," : "", i);
        }
        const auto path =
            folder_.write("s.json", fmt::format("{{\"geometries\":{{{}}},\"bodies\":[{}]}}", geometries, bodies));
        return seconds([&] { EXPECT_EQ(load_scene(path).geometries.size(), static_cast<std::size_t>(count)); });
    };
    const double few = std::min(seconds_of(4'000), seconds_of(4'000));
    EXPECT_LT(seconds_of(16'000), 10 * few + 0.5);
}

TEST_F(HostileSizes, WarningsOfManyKeysAreFoundInLinearTime)
{
    std::string keys;
    for (int i = 0; i < 80'000; ++i) keys += fmt::format("{}[{},0,0,0,0,0,0,1.01]", i ? "," : "", i);
    const auto path =
        folder_.write("s.json", fmt::format(R"({{"geometries":{{"g":{{"shape":{{"kind":"sphere","radius":1}}}}}},)"
                                            R"("bodies":[{{"geometry":"g","motion":{{"keys":[{}]}}}}]}})",
                                            keys));
    Scene scene;
    EXPECT_LT(seconds([&] { scene = load_scene(path); }), 5) << "was 55 s";
    ASSERT_EQ(scene.warnings.size(), 80'000u);
    EXPECT_NE(scene.warnings[79'999].find("bodies[0].motion.keys[79999]: quaternion"), std::string::npos);
}

} // namespace
} // namespace oncollide
