// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd.hpp>
#include <oncollide/base/simd/simd_doubles.hpp>
#include <oncollide/narrowphase/obb/fits/box_fit_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

using F64 = F64x4;
using I64 = I64x4;

struct Vec {
    F64 x, y, z;
};
inline Vec operator+(const Vec& u, const Vec& v)
{
    return {u.x + v.x, u.y + v.y, u.z + v.z};
}
inline Vec operator-(const Vec& u, const Vec& v)
{
    return {u.x - v.x, u.y - v.y, u.z - v.z};
}
inline Vec corner(const FourTriangles& four, int c)
{
    const auto lanes = [&](int axis) { return *reinterpret_cast<const F64*>(four.corners[c][axis]); };
    return {lanes(0), lanes(1), lanes(2)};
}

/// Rounds to the nearest integer; |v| is at most 2^51.
inline F64 whole(F64 v)
{
    constexpr double shift = 0x1.8p52;
    return (v + shift) - shift;
}

void extent(const FourTriangles* fours, std::size_t number, const double (&directions)[3][3], double (&low)[3],
            double (&high)[3])
{
    F64 least[3], most[3];
    for (int i = 0; i < 3; ++i) least[i] = F64{} + __builtin_inf(), most[i] = F64{} - __builtin_inf();
    for (std::size_t n = 0; n < number; ++n)
        for (int c = 0; c < 3; ++c) {
            const Vec p = corner(fours[n], c);
#pragma GCC unroll 3
            for (int i = 0; i < 3; ++i) {
                const F64 along = directions[i][0] * p.x + directions[i][1] * p.y + directions[i][2] * p.z;
                least[i] = min(least[i], along), most[i] = max(most[i], along);
            }
        }
    for (int i = 0; i < 3; ++i) {
        low[i] = least[i][0], high[i] = most[i][0];
        for (int lane = 1; lane < 4; ++lane) {
            low[i] = least[i][lane] < low[i] ? least[i][lane] : low[i];
            high[i] = most[i][lane] > high[i] ? most[i][lane] : high[i];
        }
    }
}

/// Triangles on the grid, with their areas.
struct OnGrid {
    Vec p, q, r;
    F64 area; ///< twice the area

    OnGrid(const FourTriangles& four, const double (&middle)[3], double scale)
    {
        const auto place = [&](int c) -> Vec {
            const Vec v = corner(four, c);
            return {whole((v.x - middle[0]) * scale), whole((v.y - middle[1]) * scale),
                    whole((v.z - middle[2]) * scale)};
        };
        p = place(0), q = place(1), r = place(2);
        const Vec u = q - p, v = r - p;
        const F64 x = u.y * v.z - u.z * v.y, y = u.z * v.x - u.x * v.z, z = u.x * v.y - u.y * v.x;
        area = sqrt(x * x + y * y + z * z);
    }
};

void sums(const FourTriangles* fours, std::size_t triangles, const double (&middle)[3], double scale, SurfaceSums& out)
{
    const std::size_t number = (triangles + 3) / 4;
    constexpr I64 lane{0, 1, 2, 3};
    const auto there = [&](std::size_t n) { return lane < static_cast<long long>(triangles - 4 * n); };
    F64 largest = F64{};
    for (std::size_t n = 0; n < number; ++n) {
        const F64 area = OnGrid(fours[n], middle, scale).area;
        largest = max(largest, there(n) ? area : F64{});
    }
    double most = 0;
    for (int k = 0; k < 4; ++k) most = largest[k] > most ? largest[k] : most;
    // A square is below 12 * 2^26, and its weight at most 256. There are at most 2^14, so their sum is below 2^52.
    constexpr double heaviest = 256;
    const double share_of_area = most > 0 ? heaviest / most : 0;
    F64 squares[6] = {}, sum[3] = {}, weights = F64{};
    for (std::size_t n = 0; n < number; ++n) {
        const OnGrid t(fours[n], middle, scale);
        F64 weight = F64{} + 1;
        if (most > 0) {
            const F64 share = min(t.area * share_of_area, F64{} + heaviest), nearest = whole(share);
            weight = nearest < share ? nearest + 1 : nearest; // 0 only for triangles without area
        }
        weight = there(n) ? weight : F64{};
        const Vec s = t.p + t.q + t.r;
        const auto square = [&](F64 Vec::*i, F64 Vec::*j) {
            return s.*i * (s.*j) + t.p.*i * (t.p.*j) + t.q.*i * (t.q.*j) + t.r.*i * (t.r.*j);
        };
        squares[0] += weight * square(&Vec::x, &Vec::x), squares[1] += weight * square(&Vec::y, &Vec::y);
        squares[2] += weight * square(&Vec::z, &Vec::z), squares[3] += weight * square(&Vec::x, &Vec::y);
        squares[4] += weight * square(&Vec::x, &Vec::z), squares[5] += weight * square(&Vec::y, &Vec::z);
        sum[0] += weight * s.x, sum[1] += weight * s.y, sum[2] += weight * s.z;
        weights += weight;
    }
    const auto total = [](F64 v) { return (v[0] + v[1]) + (v[2] + v[3]); };
    for (int i = 0; i < 6; ++i) out.squares[i] = total(squares[i]);
    for (int i = 0; i < 3; ++i) out.sum[i] = total(sum[i]);
    out.weight = total(weights);
}

void count_less(const float* numbers, std::size_t size, std::int32_t* less)
{
    for (std::size_t i = 0; i < size; i += 8) {
        const F32x8 eight = load(numbers + i);
        I32x8 count{};
        for (std::size_t k = 0; k < size; ++k) count -= splat(numbers[k]) < eight;
        __builtin_memcpy(less + i, &count, sizeof count);
    }
}

} // namespace

BoxFitKernel box_fit_kernel()
{
    return {extent, sums, count_less};
}

} // namespace oncollide::ONCOLLIDE_ISA
