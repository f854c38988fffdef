// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd.hpp>
#include <oncollide/narrowphase/hulls/sphere_overlap_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

struct Balls {
    alignas(32) float x[most_spheres], y[most_spheres], z[most_spheres], r[most_spheres];
    std::uint32_t count = 0;
};

inline float greatest(F32x8 v)
{
    float lanes[8], most = -__builtin_inff();
    store(lanes, v);
    for (const float lane : lanes) most = lane > most ? lane : most;
    return most;
}

/// Collects the spheres that overlap the sphere around the other mesh. Returns how far all spheres extend from its
/// centre.
template <class Placed>
inline float near_balls(const SphereColumns& from, float other_radius, Placed placed, Balls& to)
{
    F32x8 beyond = splat(-__builtin_inff());
    for (std::uint32_t i = 0; i < from.count; i += 8) {
        const F32x8 r = load(from.r + i);
        F32x8 x, y, z;
        const F32x8 distance = placed(load(from.x + i), load(from.y + i), load(from.z + i), x, y, z);
        beyond = max(beyond, distance + r);
        unsigned near = bits(distance < other_radius + r);
        if (!near) continue;
        float at[4][8];
        store(at[0], x), store(at[1], y), store(at[2], z), store(at[3], r);
        for (; near; near &= near - 1, ++to.count) {
            const auto k = static_cast<unsigned>(__builtin_ctz(near));
            to.x[to.count] = at[0][k], to.y[to.count] = at[1][k], to.z[to.count] = at[2][k], to.r[to.count] = at[3][k];
        }
    }
    return greatest(beyond);
}

SphereOverlap overlap(const SphereColumns& a, const SphereColumns& b, const float (&m)[9], const float (&t)[3])
{
    Balls of_a, of_b;
    const float beyond_b = near_balls(
        a, b.radius,
        [&](F32x8 px, F32x8 py, F32x8 pz, F32x8& x, F32x8& y, F32x8& z) {
            x = px, y = py, z = pz;
            const F32x8 dx = x - t[0], dy = y - t[1], dz = z - t[2];
            return sqrt(dx * dx + dy * dy + dz * dz);
        },
        of_a);
    const float beyond_a = near_balls(
        b, a.radius,
        [&](F32x8 px, F32x8 py, F32x8 pz, F32x8& x, F32x8& y, F32x8& z) {
            x = m[0] * px + m[1] * py + m[2] * pz + t[0];
            y = m[3] * px + m[4] * py + m[5] * pz + t[1];
            z = m[6] * px + m[7] * py + m[8] * pz + t[2];
            return sqrt(x * x + y * y + z * z);
        },
        of_b);
    for (std::uint32_t i = of_a.count; i % 8; ++i) of_a.x[i] = of_a.y[i] = of_a.z[i] = 0, of_a.r[i] = -1e30f;
    F32x8 depth = splat(0);
    for (std::uint32_t k = 0; k < of_b.count; ++k) {
        for (std::uint32_t i = 0; i < of_a.count; i += 8) {
            const F32x8 x = load(of_a.x + i) - of_b.x[k], y = load(of_a.y + i) - of_b.y[k],
                        z = load(of_a.z + i) - of_b.z[k], squared = x * x + y * y + z * z;
            const F32x8 radii = load(of_a.r + i) + of_b.r[k],
                        more = radii - depth; // overlap beyond the largest one so far
            if (bits((more > splat(0)) & (squared < more * more))) depth = max(depth, radii - sqrt(squared));
        }
    }
    return {greatest(depth), beyond_a, beyond_b};
}

} // namespace

OverlapSpheres* overlap_spheres()
{
    return overlap;
}

} // namespace oncollide::ONCOLLIDE_ISA
