#include <oncollide/narrowphase/exact/moved_apart.hpp>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/wide_vector.hpp>

namespace oncollide {

namespace {

/// The sign of the normal's first component that is not 0.
int leading_sign(const TrianglePoints& t)
{
    for (int k = 0; k < 3; ++k) {
        const auto flat = [&](const Eigen::Vector3d& p) { return Eigen::Vector2d(p[(k + 1) % 3], p[(k + 2) % 3]); };
        if (const int sign = orient2d(flat(t[0]), flat(t[1]), flat(t[2]))) return sign;
    }
    return 0;
}

} // namespace

int moved_side(const TrianglePoints& t, int exact, bool of_b)
{
    if (exact) return exact;
    return of_b ? -leading_sign(t) : leading_sign(t);
}

bool moves_along(const TrianglePoints& t)
{
    return leading_sign(t) > 0;
}

int moved_turn(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& c, const Eigen::Vector3d& d)
{
    if (const int turn = orient3d(p, q, c, d)) return turn;
    const BinaryGrid grid = grid_of_points(p, q, c, d);
    return with_limbs(grid, [&](auto limbs) {
        constexpr int n = decltype(limbs)::value;
        const auto normal = cross<n>(difference<n, 3>(grid, q, p), difference<n, 3>(grid, c, d));
        for (const auto& component : normal)
            if (const int sign = component.sign()) return sign;
        return 0;
    });
}

} // namespace oncollide
