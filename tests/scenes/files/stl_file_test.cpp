#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include <fmt/format.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>

#include "scenes/files/mesh_samples.hpp"

namespace oncollide::mesh_file_test {
namespace {

TEST(MeshFile, StlOfManyPointsIsWelded)
{
    const test::TemporaryFolder folder;
    const Mesh mesh = make_torus_mesh(2, 0.7, 60'000); // more points than fit into the cache of recent points
    const Mesh read = load_mesh(folder.write("a.stl", test::as_binary_stl(mesh)));
    EXPECT_EQ(read.vertices.size(), mesh.vertices.size());
    EXPECT_TRUE(is_closed(read));
    // NaN points equal no point; a table of them would be searched from end to end each time.
    std::string bytes = test::as_binary_stl(make_soup_mesh(200'000, 0.1, 10, 1));
    for (std::size_t at = 84 + 12 + 50; at + 12 < bytes.size(); at += 50)
        bytes.replace(at, 4, std::string("\0\0\xc0\x7f", 4));
    expect_bad("a.stl", bytes, "a corner of facet 1 is not finite");
}

TEST(MeshFile, StlIsWeldedAsOneCornerAfterTheOtherWouldBe)
{
    const test::TemporaryFolder folder;
    struct Case {
        std::uint32_t facets;
        std::uint64_t points;
    };
    // Few points, many points, nearly all different; numbers of facets around the sizes of batches.
    for (const auto& [facets, points] :
         {Case{1, 2}, {63, 5}, {64, 5}, {65, 5}, {4097, 30}, {120'000, 40}, {30'000, 5'000}}) {
        SCOPED_TRACE(fmt::format("{} facets, {} points along each axis", facets, points));
        const std::string bytes = corners_on_grid(facets, points);
        const Mesh read = load_mesh(folder.write("a.stl", bytes));
        std::map<std::array<float, 3>, std::uint32_t> numbers;
        ASSERT_EQ(read.triangles.size(), facets);
        for (std::size_t f = 0; f < facets; ++f)
            for (std::size_t k = 0; k < 3; ++k) {
                std::array<float, 3> corner;
                std::memcpy(corner.data(), bytes.data() + 84 + 50 * f + 12 + 12 * k, sizeof corner);
                const auto [known, is_new] = numbers.try_emplace(corner, numbers.size());
                ASSERT_EQ(read.triangles[f][k], known->second) << "facet " << f;
                if (!is_new) continue;
                const Vector3d& vertex = read.vertices[known->second];
                for (int axis = 0; axis < 3; ++axis) {
                    ASSERT_EQ(vertex[axis], corner[axis]);
                    ASSERT_EQ(std::signbit(vertex[axis]), std::signbit(corner[axis]))
                        << "the signs of the first corner";
                }
            }
        EXPECT_EQ(read.vertices.size(), numbers.size());
    }
}

TEST(MeshFile, EveryCornerOfAnStlThatIsNotFiniteIsNamed)
{
    const std::string bytes = corners_on_grid(5000, 20);
    for (const std::size_t facet : {0u, 63u, 64u, 4095u, 4096u, 4999u})
        for (const std::uint32_t bits : {0x7f800000u, 0xff800000u, 0x7fc00000u, 0x7f800001u, 0xffffffffu}) {
            std::string bad = bytes;
            for (std::size_t k = 0; k < 2; ++k) std::memcpy(bad.data() + 84 + 50 * facet + 24 + 4 * k, &bits, 4);
            std::memset(bad.data() + 84 + 50 * facet + 32, 0, 4);
            expect_bad("a.stl", bad, fmt::format("a corner of facet {} is not finite", facet));
        }
}

TEST(MeshFile, BinaryStlThatBeginsWithSolidIsNotText)
{
    const test::TemporaryFolder folder;
    std::string bytes = test::as_binary_stl(make_box_mesh({1, 1, 1}));
    bytes.replace(0, 5, "solid");
    EXPECT_EQ(load_mesh(folder.write("a.stl", bytes)).triangles.size(), 12u);
}

TEST(MeshFile, LinesMayEndWithCrAlone)
{
    const test::TemporaryFolder folder;
    const Mesh box = make_box_mesh({1, 2, 3});
    const auto old_mac = [](std::string text) {
        std::ranges::replace(text, '\n', '\r');
        return text;
    };
    for (const auto& [name, text] : {std::pair("a.stl", test::as_text_stl(box)),
                                     {"a.obj", test::as_obj(box)},
                                     {"a.off", test::as_off(box)},
                                     {"a.ply", test::as_text_ply(box)}}) {
        SCOPED_TRACE(name);
        const Mesh read = load_mesh(folder.write(name, old_mac(text)));
        EXPECT_EQ(read.triangles.size(), 12u);
        EXPECT_EQ(read.bounds.max, box.bounds.max);
    }
    std::string bad = test::as_text_stl(box);
    bad.replace(bad.find("endloop"), 7, "endlop!");
    expect_bad("a.stl", old_mac(bad), "line 7: 'endlop!' stands where 'endloop' should");
}

} // namespace
} // namespace oncollide::mesh_file_test
