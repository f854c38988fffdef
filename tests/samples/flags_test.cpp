#include <gtest/gtest.h>

#include <oncollide/samples/catalogue.hpp>

namespace oncollide::flags_test {
namespace {

using Eigen::Vector3d;

TEST(Catalogue, LetsFlagsWaveAtTheirPoles)
{
    Scene scene = make_scene("flags", {.bodies = 40});
    ASSERT_EQ(scene.geometries.deforming().size(), 5u);
    Mover mover;
    for (const int frame : {0, 40, 299}) {
        mover.move(scene, frame);
        for (const std::uint32_t g : scene.geometries.deforming()) {
            const auto& now = std::get<Mesh>(scene.geometries[g].data).vertices;
            const auto& rest = std::get<Mesh>(scene.geometries.at_rest(g).data).vertices;
            for (std::size_t v = 0; v < now.size(); ++v) {
                if (rest[v].x() == -0.75) {
                    EXPECT_TRUE(now[v].isApprox(rest[v], 1e-14));
                }
                EXPECT_LE((now[v] - Vector3d(-0.75, now[v].y(), 0)).norm(), 1.51);
            }
        }
    }
    const Scene other = make_scene("flags", {.bodies = 40, .seed = 2});
    EXPECT_NE(std::get<Mesh>(scene.geometries[0].data).vertices, std::get<Mesh>(other.geometries[0].data).vertices);
}

} // namespace
} // namespace oncollide::flags_test
