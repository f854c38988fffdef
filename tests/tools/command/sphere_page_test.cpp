#include "robot/sphere_page.hpp"

#include "robots/small_robot.hpp"
#include "tools/command_fixture.hpp"
#include "tools/decoded_png.hpp"
#include "tools/view_fixture.hpp"

namespace oncollide::test {
namespace {

TEST(SpherePage, DividesTheSurfaceAtTheSpheres)
{
    const Geometry box{"box", Box{{0.5, 0.5, 0.5}}, {}};
    const LinkSurface surface({"box", {{std::make_shared<const Geometry>(box)}}});
    const std::vector<CoverSphere> spheres = {{{0.5, 0, 0}, 0.4}, {{0, 0, 1}, 0.3}}; // a disc of one face, and nothing
    const tools::DividedSurface parts = tools::divide(surface, spheres, 0.05);
    double covered = 0, uncovered = 0;
    for (const auto& triangle : parts.covered) covered += area_of(triangle);
    for (const auto& triangle : parts.uncovered) uncovered += area_of(triangle);
    EXPECT_NEAR(covered, M_PI * 0.16, 0.01);
    EXPECT_NEAR(covered + uncovered, 6, 1e-9);
    for (const auto& triangle : parts.covered) EXPECT_NEAR(triangle[0].x(), 0.5, 1e-12);
    for (const auto& triangle : parts.uncovered)
        if (triangle[0].x() > 0.49) {
            EXPECT_GT(triangle[0].tail<2>().norm(), 0.35);
        }
}

std::vector<Decoded> pictures_of(const std::string& page)
{
    std::vector<Decoded> pictures;
    const std::string before = "data:image/png;base64,";
    for (std::size_t at = 0; (at = page.find(before, at)) != page.npos;) {
        at += before.size();
        pictures.push_back(decode(decoded_base64(std::string_view(page).substr(at, page.find('"', at) - at))));
    }
    return pictures;
}

class SpherePageCommand : public CommandLine {
protected:
    /// Half of the base's box is in a sphere; all of the ball is; the other links have none.
    Outcome judge(Surroundings around = {})
    {
        folder_.write("half.yml", "collision_spheres:\n  base:\n    - {center: [0.15, 0, 0], radius: 0.3}\n"
                                  "  left:\n    - {center: [0, 0, 0], radius: 0.021}\n");
        return run({"spheres", robot_.urdf.string(), "--package", "robot=" + robot_.folder().path().string(), "--judge",
                    "half.yml", "--html", "page.html"},
                   around);
    }
    SmallRobot robot_;
};

TEST_F(SpherePageCommand, ShowsWhatIsInNoSphere)
{
    const Outcome outcome = judge();
    if (outcome.err.find("build without") != std::string::npos) GTEST_SKIP() << outcome.err;
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    const std::string page = folder_.read("page.html");
    EXPECT_NE(page.find("<h1>arm: half.yml</h1>"), std::string::npos);
    EXPECT_NE(page.find("base: 1 sphere; "), std::string::npos) << page.substr(0, 4000);
    EXPECT_NE(page.find("Worst gap 118.3 mm at -0.150"), std::string::npos);
    EXPECT_NE(page.find("left: 1 sphere contain all of the surface."), std::string::npos);
    EXPECT_NE(page.find("upper: 0 spheres; 100.0 to 100.0 % of the surface is in none."), std::string::npos);
    if (page.find("No pictures: ") != std::string::npos) GTEST_SKIP() << "no renderer";
    const std::vector<Decoded> pictures = pictures_of(page);
    ASSERT_EQ(pictures.size(), 5u); // of base, upper, lower, left, right
    const auto orange = [](const std::uint8_t* p) { return p[0] > 1.5 * p[2] && p[1] > p[2]; };
    const auto grey = [](const std::uint8_t* p) { return p[0] < 245 && p[2] >= p[0]; };
    const auto red = [](const std::uint8_t* p) { return p[0] > 150 && p[1] < 20; };
    const auto shares = [&](const Decoded& picture) {
        return std::array{picture.count(orange, 0, 360), picture.count(grey, 0, 360), picture.count(red, 0, 360)};
    };
    const auto [base_orange, base_grey, base_red] = shares(pictures[0]);
    EXPECT_TRUE(base_orange > 2000 && base_grey > 200 && base_red >= 60)
        << base_orange << " " << base_grey << " " << base_red;
    const auto [upper_orange, upper_grey, upper_red] = shares(pictures[1]);
    EXPECT_TRUE(upper_orange > 500 && upper_grey == 0 && upper_red == 0) << upper_orange << " " << upper_grey;
    const auto [left_orange, left_grey, left_red] = shares(pictures[3]);
    EXPECT_TRUE(left_orange == 0 && left_grey > 2000 && left_red == 0) << left_orange << " " << left_grey;
}

} // namespace
} // namespace oncollide::test
