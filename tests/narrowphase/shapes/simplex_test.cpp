#include <gtest/gtest.h>

#include <random>

#include <oncollide/narrowphase/shapes/simplex.hpp>

namespace oncollide::simplex_test {
namespace {

using Eigen::Vector3d;

/// The hull's points at a grid of weights.
double least_of_grid(const Simplex4& s, int steps)
{
    double least = s.corner[0].w.norm();
    const auto visit = [&](const Vector3d& p) { least = std::min(least, p.norm()); };
    for (int i = 0; i <= steps; ++i)
        for (int j = 0; i + j <= steps; ++j)
            for (int k = 0; i + j + k <= steps; ++k) {
                const int l = steps - i - j - k;
                const std::array<int, 4> share{l, i, j, k};
                Vector3d p = Vector3d::Zero();
                bool inside = true;
                for (std::size_t c = 0; c < 4; ++c) {
                    if (int(c) < s.count)
                        p += share[c] * s.corner[c].w;
                    else
                        inside &= share[c] == 0;
                }
                if (inside) visit(p / steps);
            }
    return least;
}

TEST(Simplex, ReducesToTheCornersOfTheNearestPoint)
{
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> real(-1, 1);
    int around = 0;
    for (int k = 0; k < 2'000; ++k) {
        Simplex4 simplex;
        simplex.count = 1 + k % 4;
        const Vector3d shift(real(random), real(random), real(random));
        for (int i = 0; i < simplex.count; ++i) {
            const Vector3d a(real(random), real(random), real(random));
            simplex.corner[std::size_t(i)] = {a + (k % 3 ? shift : Vector3d(Vector3d::Zero())), a};
        }
        const Simplex4 before = simplex;
        simplex.reduce();
        ASSERT_GE(simplex.count, 1);
        ASSERT_LE(simplex.count, before.count);
        double sum = 0;
        for (int i = 0; i < simplex.count; ++i) {
            EXPECT_GE(simplex.weight[std::size_t(i)], 0);
            EXPECT_TRUE(before.holds(simplex.corner[std::size_t(i)].w)) << "corners are kept or dropped";
            sum += simplex.weight[std::size_t(i)];
        }
        EXPECT_NEAR(sum, 1, 1e-14);
        const double found = simplex.nearest().norm(), grid = least_of_grid(before, 16);
        EXPECT_LE(found, grid + 1e-12) << k;
        if (simplex.count == 4) {
            ++around;
            EXPECT_LT(found, 1e-12) << "only a tetrahedron around 0 keeps its corners";
        }
    }
    EXPECT_GT(around, 10);
}

} // namespace
} // namespace oncollide::simplex_test
