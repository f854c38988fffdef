// Compiled once per instruction set; see oncollide_add_kernel.
#include <oncollide/base/simd/simd.hpp>
#include <oncollide/base/simd/simd_doubles.hpp>
#include <oncollide/narrowphase/obb/fits/box_fit_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

// A lane is a box, or an eighth of the triangles of one large box: four lanes at a time in double, all eight in float.
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
inline Vec operator*(const Vec& v, F64 by)
{
    return {v.x * by, v.y * by, v.z * by};
}
inline F64 dot(const Vec& u, const Vec& v)
{
    return u.x * v.x + u.y * v.y + u.z * v.z;
}
inline Vec choose(I64 which, const Vec& u, const Vec& v)
{
    return {which ? u.x : v.x, which ? u.y : v.y, which ? u.z : v.z};
}
inline F64 splat64(double v)
{
    return F64{v, v, v, v};
}
inline F64 abs64(F64 v)
{
    return reinterpret_cast<F64>(reinterpret_cast<I64>(v) & 0x7fffffffffffffff);
}
/// Rounds to the nearest integer; |v| is at most 2^51.
inline F64 whole(F64 v)
{
    constexpr double shift = 0x1.8p52;
    return (v + shift) - shift;
}

/// Four lanes of the rows.
struct Rows {
    const EightTriangles* rows;
    std::uint32_t number;
    int first;  ///< lane
    I64 counts; ///< number of triangles, by lane

    Vec corner(std::uint32_t row, int c) const
    {
        const auto lanes = [&](int axis) { return *reinterpret_cast<const F64*>(&rows[row].corners[c][axis][first]); };
        return {lanes(0), lanes(1), lanes(2)};
    }
    I64 used(std::uint32_t row) const { return counts > static_cast<long long>(row); }
};

struct Extent {
    F64 low[3], high[3];

    F64 middle(int i) const { return 0.5 * (low[i] + high[i]); }
    F64 half(int i) const { return 0.5 * (high[i] - low[i]); }
    F64 area() const { return half(0) * half(1) + half(1) * half(2) + half(2) * half(0); }
    F64 least() const { return min(half(0), min(half(1), half(2))); }
};

/// @param along  the projections of a corner onto three directions
inline Extent extent(const Rows& boxes, auto along)
{
    Extent out;
    for (int i = 0; i < 3; ++i) out.low[i] = splat64(__builtin_inf()), out.high[i] = splat64(-__builtin_inf());
    for (std::uint32_t row = 0; row < boxes.number; ++row)
        for (int c = 0; c < 3; ++c) {
            const Vec p = along(boxes.corner(row, c));
            out.low[0] = min(out.low[0], p.x), out.high[0] = max(out.high[0], p.x);
            out.low[1] = min(out.low[1], p.y), out.high[1] = max(out.high[1], p.y);
            out.low[2] = min(out.low[2], p.z), out.high[2] = max(out.high[2], p.z);
        }
    return out;
}

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
struct Spread {
    F64 of[6];
};

/// Triangles on a grid on which their corners are at most 2^13 steps from the middle of the box.
struct OnGrid {
    Vec p, q, r;

    OnGrid(const Rows& boxes, std::uint32_t row, const Extent& extent, F64 scale)
    {
        const auto place = [&](int c) -> Vec {
            const Vec v = boxes.corner(row, c);
            return {whole((v.x - extent.middle(0)) * scale), whole((v.y - extent.middle(1)) * scale),
                    whole((v.z - extent.middle(2)) * scale)};
        };
        p = place(0), q = place(1), r = place(2);
    }
    F64 area2() const ///< four times the square of the area
    {
        const Vec u = q - p, v = r - p;
        const F64 x = u.y * v.z - u.z * v.y, y = u.z * v.x - u.x * v.z, z = u.x * v.y - u.y * v.x;
        return x * x + y * y + z * z;
    }
};

/// The largest area2() of a triangle. Rows that repeat a triangle change nothing.
inline F64 largest_area2(const Rows& boxes, const Extent& extent, F64 scale)
{
    F64 largest{};
    for (std::uint32_t row = 0; row < boxes.number; ++row)
        largest = max(largest, OnGrid(boxes, row, extent, scale).area2());
    return largest;
}

/// Weighted sums over triangles: six squares, three coordinates, and the weights. They are of integers and below 2^53,
/// so they are exact: the result does not depend on the order of triangles and corners, even if the surface spreads
/// equally in all directions.
struct Sums {
    F64 of[10];
};

/// Weights are areas; for a surface without area, all weights are 1.
inline Sums sums_of_surface(const Rows& boxes, const Extent& extent, F64 scale, F64 largest)
{
    // A square is below 12 * 2^26, and its weight at most 256. There are at most 2^14, so their sum is below 2^52.
    constexpr double heaviest = 256;
    const I64 flat = largest == F64{};
    const F64 share_of_area = heaviest / sqrt(flat ? splat64(1) : largest);
    F64 squares[6] = {}, weights{};
    Vec sum{};
    for (std::uint32_t row = 0; row < boxes.number; ++row) {
        const OnGrid t(boxes, row, extent, scale);
        const F64 share = min(sqrt(t.area2()) * share_of_area, splat64(heaviest)), nearest = whole(share);
        F64 weight = nearest < share ? nearest + 1 : nearest; // 0 only for triangles without area
        weight = flat ? splat64(1) : weight;
        weight = boxes.used(row) ? weight : F64{};
        const Vec s = t.p + t.q + t.r;
        const auto square = [&](F64 Vec::*i, F64 Vec::*j) {
            return s.*i * (s.*j) + t.p.*i * (t.p.*j) + t.q.*i * (t.q.*j) + t.r.*i * (t.r.*j);
        };
        squares[0] += weight * square(&Vec::x, &Vec::x), squares[1] += weight * square(&Vec::y, &Vec::y);
        squares[2] += weight * square(&Vec::z, &Vec::z), squares[3] += weight * square(&Vec::x, &Vec::y);
        squares[4] += weight * square(&Vec::x, &Vec::z), squares[5] += weight * square(&Vec::y, &Vec::z);
        sum = sum + s * weight, weights += weight;
    }
    return {{squares[0], squares[1], squares[2], squares[3], squares[4], squares[5], sum.x, sum.y, sum.z, weights}};
}

/// Second moments of the surface; for a surface without area, of its corners.
inline Spread spread_of(const Sums& sums)
{
    const F64 weights = max(sums.of[9], splat64(1));
    const Vec mean{sums.of[6] / (3 * weights), sums.of[7] / (3 * weights), sums.of[8] / (3 * weights)};
    const F64 products[6] = {mean.x * mean.x, mean.y * mean.y, mean.z * mean.z,
                             mean.x * mean.y, mean.x * mean.z, mean.y * mean.z};
    Spread spread;
    for (int i = 0; i < 6; ++i) spread.of[i] = sums.of[i] / (12 * weights) - products[i];
    return spread;
}

/// Joins the eight lanes of both halves by `join`, and sets all of them to the result.
inline void join_lanes(F64& first, F64& second, auto join)
{
    F64 all = join(first, second);
    all = join(all, F64{all[2], all[3], all[0], all[1]});
    first = second = join(all, F64{all[1], all[0], all[3], all[2]});
}
constexpr auto least_of = [](F64 u, F64 v) { return min(u, v); };
constexpr auto most_of = [](F64 u, F64 v) { return max(u, v); };
constexpr auto sum_of = [](F64 u, F64 v) { return u + v; };
inline void join_lanes(Extent (&halves)[2])
{
    for (int i = 0; i < 3; ++i) {
        join_lanes(halves[0].low[i], halves[1].low[i], least_of);
        join_lanes(halves[0].high[i], halves[1].high[i], most_of);
    }
}

/// A matrix with the axes of one triangle: its normal, and its longest side or, with a right angle, a leg.
inline Spread spread_of_triangle(const Rows& boxes, F64 scale)
{
    const Vec p = boxes.corner(0, 0), a = (boxes.corner(0, 1) - p) * scale, b = (boxes.corner(0, 2) - p) * scale,
              c = b - a;
    const F64 aa = dot(a, a), bb = dot(b, b), cc = dot(c, c), longest = max(aa, max(bb, cc));
    const F64 middle = max(min(aa, bb), min(max(aa, bb), cc));
    const F64 length2 = abs64(aa + bb + cc - 2 * longest) < 0.001 * longest ? middle : longest;
    const auto unit = [](const Vec& v, F64 square, F64 least) {
        return v * (square > least ? 1 / sqrt(square > least ? square : splat64(1)) : F64{});
    };
    const Vec u = unit(choose(aa == length2, a, choose(bb == length2, b, c)), length2, F64{});
    const Vec other = choose(aa == length2, b, a), rest = other - u * dot(u, other);
    const Vec v = unit(rest, dot(rest, rest), 1e-24 * longest);
    return {u.x * u.x + 0.5 * v.x * v.x, u.y * u.y + 0.5 * v.y * v.y, u.z * u.z + 0.5 * v.z * v.z,
            u.x * u.y + 0.5 * v.x * v.y, u.x * u.z + 0.5 * v.x * v.z, u.y * u.z + 0.5 * v.y * v.z};
}

/// Axes as quaternions: w, x, y, z.
struct Turns {
    F32x8 of[4];
};

/// One rotation of Jacobi's method, in the plane of axes p and q, with an approximate angle that needs no trigonometry.
/// Source: McAdams et al., "Computing the singular value decomposition of 3x3 matrices with minimal branching and
/// elementary floating point operations", 2011.
inline void rotate(F32x8& pp, F32x8& pq, F32x8& qq, F32x8& pk, F32x8& qk, Turns& turn, int p, int q, int k)
{
    constexpr float most = 5.8284271f, cosine = 0.92387953f, sine = 0.38268343f; // 3 + 2 sqrt(2); of pi / 8
    const F32x8 none = splat(0), one = splat(1), across = 2 * (pp - qq);
    const I32x8 some = abs(pq) > splat(1e-12f), small = most * pq * pq < across * across;
    const F32x8 length2 = across * across + pq * pq, by = 1 / sqrt(some ? length2 : one);
    const F32x8 ch = some ? (small ? across * by : splat(cosine)) : one,
                sh = some ? (small ? pq * by : splat(sine)) : none;
    const F32x8 c = ch * ch - sh * sh, s = 2 * sh * ch;
    const F32x8 a = c * pp + s * pq, b = c * pq + s * qq, d = c * pq - s * pp, e = c * qq - s * pq;
    pp = c * a + s * b, pq = c * b - s * a, qq = c * e - s * d;
    const F32x8 rest = c * pk + s * qk;
    qk = c * qk - s * pk, pk = rest;
    const F32x8 w = turn.of[0], x = turn.of[p], y = turn.of[q], z = turn.of[k];
    turn.of[0] = w * ch - z * sh, turn.of[k] = z * ch + w * sh;
    turn.of[p] = x * ch + y * sh, turn.of[q] = y * ch - x * sh;
}

/// The axes of symmetric matrices whose trace is 1, or 0.
inline Turns principal_turns(const float (&of)[6][8])
{
    constexpr int sweeps = 4;
    F32x8 xx = load(of[0]), yy = load(of[1]), zz = load(of[2]), xy = load(of[3]), xz = load(of[4]), yz = load(of[5]);
    Turns turn{splat(1), splat(0), splat(0), splat(0)};
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        rotate(xx, xy, yy, xz, yz, turn, 1, 2, 3);
        rotate(yy, yz, zz, xy, xz, turn, 2, 3, 1);
        rotate(zz, xz, xx, yz, xy, turn, 3, 1, 2);
    }
    const auto& [w, x, y, z] = turn.of;
    const F32x8 by = static_cast<float>(quaternion_steps) / sqrt(w * w + x * x + y * y + z * z);
    for (F32x8& part : turn.of) {
        constexpr float shift = 0x1.8p23f; // rounds to integers
        part = (min(max(part * by, splat(-32767)), splat(32767)) + shift) - shift;
    }
    return turn;
}

/// The axes of stored quaternions, by component, as the box test reads them: the same operations in the same order.
inline void read_axes(const Turns& turn, float (&axes)[3][3][8])
{
    F32x8 w = turn.of[0] * (1.0f / 32767), x = turn.of[1] * (1.0f / 32767), y = turn.of[2] * (1.0f / 32767),
          z = turn.of[3] * (1.0f / 32767);
    const F32x8 stretch = 1.5f - 0.5f * (w * w + x * x + y * y + z * z);
    w = w * stretch, x = x * stretch, y = y * stretch, z = z * stretch;
    const F32x8 x2 = x + x, y2 = y + y, z2 = z + z;
    const F32x8 xx = x * x2, yy = y * y2, zz = z * z2, xy = x * y2, xz = x * z2, yz = y * z2, wx = w * x2, wy = w * y2,
                wz = w * z2;
    const F32x8 of[3][3] = {
        {1 - (yy + zz), xy + wz, xz - wy}, {xy - wz, 1 - (xx + zz), yz + wx}, {xz + wy, yz - wx, 1 - (xx + yy)}};
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < 3; ++i) store(axes[axis][i], of[axis][i]);
}

inline F64 widened(const float (&eight)[8], int first)
{
    return F64{eight[first], eight[first + 1], eight[first + 2], eight[first + 3]};
}

/// Stores the nearest centres, and half-extents that cover the extents along the axes.
inline void put(const Extent& along, const Vec (&axes)[3], const StoredFrame& frame, const Rows& boxes,
                StoredBoxes& out)
{
    const F64 unit = splat64(frame.unit), none{};
    const F64 middle[3] = {along.middle(0), along.middle(1), along.middle(2)};
    const Vec centre = axes[0] * middle[0] + axes[1] * middle[1] + axes[2] * middle[2];
    const F64 at[3] = {centre.x, centre.y, centre.z};
    F64 steps[3], placed[3];
    for (int i = 0; i < 3; ++i) {
        const F64 from = (at[i] - double(frame.origin[i])) / unit;
        steps[i] = whole(min(max(from, splat64(-most_place)), splat64(most_place)));
        placed[i] = double(frame.origin[i]) + steps[i] * unit;
    }
    const Vec stored{placed[0], placed[1], placed[2]};
    for (int i = 0; i < 3; ++i) {
        const F64 place = dot(axes[i], stored);
        const F64 rounding = 0x1p-50 * max(abs64(along.low[i]), abs64(along.high[i]));
        const F64 half = max(along.high[i] - place, place - along.low[i]) + rounding;
        const F64 wanted = min(max(half / unit * (1 + 0x1p-20), none), splat64(most_half)), nearest = whole(wanted);
        const F64 covering = nearest < wanted ? nearest + 1 : nearest;
        for (int lane = 0; lane < 4; ++lane) {
            const bool used = boxes.counts[lane] > 0;
            out.place[i][boxes.first + lane] = static_cast<std::int16_t>(used ? steps[i][lane] : 0);
            out.half[i][boxes.first + lane] = static_cast<std::uint16_t>(used ? covering[lane] : 0);
        }
    }
}

/// The spread of each lane's surface, or of the surface of all lanes together, divided by its trace.
template <bool one_box>
inline void spread_of_rows(const Rows (&halves)[2], const Extent (&straight)[2], float (&spread)[6][8])
{
    F64 scale[2], largest[2];
    Sums sums[2];
    for (int half = 0; half < 2; ++half) {
        const Extent& all = straight[half];
        const F64 size = max(all.half(0), max(all.half(1), all.half(2)));
        const I64 tiny = size < splat64(1e-290);
        scale[half] = tiny ? F64{} : 0x1p13 / (tiny ? splat64(1) : size);
        largest[half] = largest_area2(halves[half], all, scale[half]);
    }
    if constexpr (one_box) join_lanes(largest[0], largest[1], most_of);
    for (int half = 0; half < 2; ++half)
        sums[half] = sums_of_surface(halves[half], straight[half], scale[half], largest[half]);
    if constexpr (one_box)
        for (int i = 0; i < 10; ++i) join_lanes(sums[0].of[i], sums[1].of[i], sum_of);
    for (int half = 0; half < 2; ++half) {
        Spread of = spread_of(sums[half]);
        const I64 single = halves[half].counts == 1;
        if (!one_box && (single[0] | single[1] | single[2] | single[3])) {
            const Spread alone = spread_of_triangle(halves[half], scale[half]);
            for (int i = 0; i < 6; ++i) of.of[i] = single ? alone.of[i] : of.of[i];
        }
        const F64 trace = of.of[0] + of.of[1] + of.of[2], by = 1 / (trace > F64{} ? trace : splat64(1));
        for (int k = 0; k < 24; ++k)
            spread[k / 4][4 * half + k % 4] = static_cast<float>(of.of[k / 4][k % 4] * by[k % 4]);
    }
}

template <bool one_box>
void fit(const EightTriangles* rows, const std::uint32_t (&counts)[8], const StoredFrame& frame, StoredBoxes& out)
{
    std::uint32_t number = 0;
    for (const std::uint32_t count : counts) number = count > number ? count : number;
    Rows boxes[2] = {{rows, number, 0, {}}, {rows, number, 4, {}}};
    for (int k = 0; k < 8; ++k) boxes[k / 4].counts[k % 4] = counts[k];
    const auto itself = [](const Vec& p) { return p; };
    Extent straight[2] = {extent(boxes[0], itself), extent(boxes[1], itself)}, along[2];
    if constexpr (one_box) join_lanes(straight);
    float spread[6][8];
    spread_of_rows<one_box>(boxes, straight, spread);
    Turns turn = principal_turns(spread);
    float fitted_axes[3][3][8];
    read_axes(turn, fitted_axes);
    Vec axes[2][3];
    for (int half = 0; half < 2; ++half) {
        for (int axis = 0; axis < 3; ++axis)
            axes[half][axis] = {widened(fitted_axes[axis][0], 4 * half), widened(fitted_axes[axis][1], 4 * half),
                                widened(fitted_axes[axis][2], 4 * half)};
        along[half] = extent(boxes[half], [&](const Vec& p) {
            return Vec{dot(axes[half][0], p), dot(axes[half][1], p), dot(axes[half][2], p)};
        });
    }
    if constexpr (one_box) join_lanes(along);
    alignas(32) std::int32_t turned[8];
    for (int half = 0; half < 2; ++half) {
        // The frame's axes fit geometry built along them better; but a thicker box bounds a curved surface worse.
        const Extent &all = straight[half], &fitted = along[half];
        const I64 along_frame = (all.area() < 0.95 * fitted.area()) & (all.least() <= 1.25 * fitted.least());
        for (int i = 0; i < 3; ++i) {
            along[half].low[i] = along_frame ? all.low[i] : along[half].low[i];
            along[half].high[i] = along_frame ? all.high[i] : along[half].high[i];
            axes[half][i] = choose(along_frame, {splat64(i == 0), splat64(i == 1), splat64(i == 2)}, axes[half][i]);
        }
        for (int lane = 0; lane < 4; ++lane)
            turned[4 * half + lane] = boxes[half].counts[lane] == 0 ? 0 : along_frame[lane] ? 1 : -1;
        put(along[half], axes[half], frame, boxes[half], out);
    }
    for (int part = 0; part < 4; ++part) {
        float steps[8];
        store(steps, turn.of[part]);
        for (int k = 0; k < 8; ++k) {
            const float frames = part == 0 ? static_cast<float>(quaternion_steps) : 0;
            out.turn[part][k] = static_cast<std::int16_t>(turned[k] == 0 ? 0 : turned[k] > 0 ? frames : steps[k]);
        }
    }
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
    return {fit<false>, fit<true>, count_less};
}

} // namespace oncollide::ONCOLLIDE_ISA
