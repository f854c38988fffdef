// Compiled once per instruction set; see oncollide_add_kernel.
#include <cstddef>

#include <oncollide/narrowphase/obb/open_boxes.hpp>
#include <oncollide/narrowphase/obb/oriented_box_kernel.hpp>

namespace oncollide::ONCOLLIDE_ISA {
namespace {

enum class Kind { near, likely, far };

/// @param line  the line for a far query; else null
template <Kind kind>
inline unsigned compare(const OpenBoxes& boxes, const OpenBoxes& other, unsigned k, const BoxLine* line,
                        float gap_limit, float (&gaps)[8], float (&nearest)[8])
{
    constexpr bool far = kind == Kind::far;
    const Vec d{load(boxes.c[0]) - other.c[0][k], load(boxes.c[1]) - other.c[1][k], load(boxes.c[2]) - other.c[2][k]};
    const F32x8 h[3] = {load(boxes.h[0]), load(boxes.h[1]), load(boxes.h[2])};
    const float oh[3] = {other.h[0][k], other.h[1][k], other.h[2][k]};
    const Vec axis[3] = {load(boxes.axis[0]), load(boxes.axis[1]), load(boxes.axis[2])};
    F32x8 c[3][3], a[3][3], t[3]; // c: cosines [of the other's axis][of the lane's axis]; a: their absolute values
    F32x8 gap = splat(-__builtin_inff());
    F32x8 radii_by_length = splat(0); // along the line of centres
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const float x = other.axis[i][0][k], y = other.axis[i][1][k], z = other.axis[i][2][k];
        t[i] = x * d.x + y * d.y + z * d.z;
#pragma GCC unroll 3
        for (int j = 0; j < 3; ++j) {
            c[i][j] = x * axis[j].x + y * axis[j].y + z * axis[j].z;
            a[i][j] = abs(c[i][j]);
        }
        gap = max(gap, abs(t[i]) - oh[i] - (h[0] * a[i][0] + h[1] * a[i][1] + h[2] * a[i][2]));
    }
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) {
        const F32x8 along = dot(axis[j], d);
        gap = max(gap, abs(along) - h[j] - (oh[0] * a[0][j] + oh[1] * a[1][j] + oh[2] * a[2][j]));
        if constexpr (far) radii_by_length = radii_by_length + h[j] * abs(along);
    }
    if constexpr (far) {
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) radii_by_length = radii_by_length + oh[i] * abs(t[i]);
        const F32x8 length = sqrt(dot(d, d));
        // The quotient is undefined in unused lanes, which then keep the gap so far.
        gap = max(length > splat(0) ? length - radii_by_length / length : gap, gap);
        const float x = line->direction[0], y = line->direction[1], z = line->direction[2];
        F32x8 least = x * load(boxes.c[0]) + y * load(boxes.c[1]) + z * load(boxes.c[2]);
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) least = least - h[i] * abs(x * axis[i].x + y * axis[i].y + z * axis[i].z);
        gap = max(gap, least - line->other_reach);
    }
    const float margin = boxes.margin + other.margin;
    // The cross products of edges hardly ever separate boxes that are smaller than their distance.
    const float gap_limit2 = gap_limit * gap_limit;
    const bool small = far && other.size[k] < gap_limit2 && !bits(load(boxes.size) >= splat(gap_limit2));
    if (!small && bits(gap <= splat(gap_limit + margin))) {
        // Cross products have length at most 1, so projections onto them are lower bounds of the distance.
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
#pragma GCC unroll 3
            for (int j = 0; j < 3; ++j) {
                const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
                const F32x8 apart = abs(t[i2] * c[i1][j] - t[i1] * c[i2][j]);
                const F32x8 radii = oh[i1] * a[i2][j] + oh[i2] * a[i1][j] + h[j1] * a[i][j2] + h[j2] * a[i][j1];
                gap = max(gap, apart - radii);
            }
        }
    }
    gap = gap - margin;
    const I32x8 near = gap <= splat(gap_limit);
    const F32x8 before = load(nearest);
    store(gaps, kind == Kind::likely ? gap + 2 * sqrt(dot(d, d)) : gap);
    store(nearest, near ? before : min(before, gap));
    return bits(near);
}

unsigned compare_near(const OpenBoxes& boxes, const OpenBoxes& other, unsigned k, float gap_limit, float (&gaps)[8],
                      float (&nearest)[8])
{
    return compare<Kind::near>(boxes, other, k, nullptr, gap_limit, gaps, nearest);
}

unsigned compare_likely(const OpenBoxes& boxes, const OpenBoxes& other, unsigned k, float gap_limit, float (&order)[8],
                        float (&nearest)[8])
{
    return compare<Kind::likely>(boxes, other, k, nullptr, gap_limit, order, nearest);
}

unsigned compare_far(const OpenBoxes& boxes, const OpenBoxes& other, unsigned k, const BoxLine& line, float gap_limit,
                     float (&gaps)[8], float (&nearest)[8])
{
    return compare<Kind::far>(boxes, other, k, &line, gap_limit, gaps, nearest);
}

float reach(const OpenBoxes& boxes, const float (&direction)[3])
{
    const float x = direction[0], y = direction[1], z = direction[2];
    const F32x8 cx = load(boxes.c[0]);
    F32x8 most = x * cx + y * load(boxes.c[1]) + z * load(boxes.c[2]);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i)
        most = most + load(boxes.h[i]) *
                          abs(x * load(boxes.axis[i][0]) + y * load(boxes.axis[i][1]) + z * load(boxes.axis[i][2]));
    most = cx < splat(0.5f * far_away) ? most : splat(-far_away);
    most = max(most, ONCOLLIDE_SHUFFLE(most, 4, 5, 6, 7, 0, 1, 2, 3));
    most = max(most, ONCOLLIDE_SHUFFLE(most, 2, 3, 0, 1, 6, 7, 4, 5));
    most = max(most, ONCOLLIDE_SHUFFLE(most, 1, 0, 3, 2, 5, 4, 7, 6));
    return most[0];
}

void from_point(const OpenBoxes& boxes, const float (&point)[3], float (&distance2)[8])
{
    const Vec d{point[0] - load(boxes.c[0]), point[1] - load(boxes.c[1]), point[2] - load(boxes.c[2])};
    F32x8 sum = splat(0);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const F32x8 out = max(abs(dot(load(boxes.axis[i]), d)) - load(boxes.h[i]), splat(0));
        sum = sum + out * out;
    }
    store(distance2, sum);
}

/// The times, between `first` and `last`, at which eight boxes may overlap another one along all axes so far.
class Overlap {
public:
    Overlap(float until, F32x8 slack) : first_(splat(-1)), last_(splat(until)), slack_(slack) {}
    /// @param at, speed  of the distance of the centres along an axis of length 1 at most @param radii  of both boxes
    void cut(F32x8 at, F32x8 speed, F32x8 radii)
    {
        // The slack exceeds the rounding of `at`, so no quotient is 0 / 0 for boxes that overlap all the time.
        constexpr float least = 1e-37f;
        const F32x8 wide = radii + slack_, toward = speed < splat(0) ? -at : at, by = 1 / max(abs(speed), splat(least));
        first_ = max(first_, (-wide - toward) * by), last_ = min(last_, (wide - toward) * by);
    }
    F32x8 first() const { return first_; }
    I32x8 some() const { return first_ <= last_; }

private:
    F32x8 first_, last_, slack_;
};

unsigned meet_in_time(const OpenBoxes& boxes, const OpenBoxes& other, unsigned k, const BoxMotion& m, float until,
                      float (&entries)[8])
{
    const Vec centre = load(boxes.c);
    const Vec d{centre.x - other.c[0][k], centre.y - other.c[1][k], centre.z - other.c[2][k]};
    const Vec base{splat(m.base[0]), splat(m.base[1]), splat(m.base[2])},
        turn{splat(m.turn[0]), splat(m.turn[1]), splat(m.turn[2])};
    const Vec turned = cross(turn, centre), v{base.x + turned.x, base.y + turned.y, base.z + turned.z};
    // Far along the motion, rounding is larger than the margins of boxes that touch at time 0.
    const F32x8 speeds =
        abs(base.x) + abs(base.y) + abs(base.z) + m.turn_length * (abs(centre.x) + abs(centre.y) + abs(centre.z));
    const F32x8 slack =
        m.slack + boxes.margin + other.margin + m.turn_length * 1.0001f * sqrt(load(boxes.size)) + 0x1p-16f * speeds;
    const F32x8 h[3] = {load(boxes.h[0]), load(boxes.h[1]), load(boxes.h[2])};
    const float oh[3] = {other.h[0][k], other.h[1][k], other.h[2][k]};
    Vec axis[3];
    F32x8 c[3][3], a[3][3], t[3], u[3]; // as in compare(); t, u: the distance of the centres and its change
    Overlap times(until, slack);
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j) axis[j] = load(boxes.axis[j]);
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const float x = other.axis[i][0][k], y = other.axis[i][1][k], z = other.axis[i][2][k];
        t[i] = x * d.x + y * d.y + z * d.z, u[i] = x * v.x + y * v.y + z * v.z;
#pragma GCC unroll 3
        for (int j = 0; j < 3; ++j) {
            c[i][j] = x * axis[j].x + y * axis[j].y + z * axis[j].z;
            a[i][j] = abs(c[i][j]);
        }
        times.cut(t[i], u[i], oh[i] + (h[0] * a[i][0] + h[1] * a[i][1] + h[2] * a[i][2]));
    }
#pragma GCC unroll 3
    for (int j = 0; j < 3; ++j)
        times.cut(dot(axis[j], d), dot(axis[j], v), h[j] + (oh[0] * a[0][j] + oh[1] * a[1][j] + oh[2] * a[2][j]));
    const I32x8 used = centre.x < splat(0.5f * far_away);
    if (bits(times.some() & used)) {
#pragma GCC unroll 3
        for (int i = 0; i < 3; ++i) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
#pragma GCC unroll 3
            for (int j = 0; j < 3; ++j) {
                const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
                times.cut(t[i2] * c[i1][j] - t[i1] * c[i2][j], u[i2] * c[i1][j] - u[i1] * c[i2][j],
                          oh[i1] * a[i2][j] + oh[i2] * a[i1][j] + h[j1] * a[i][j2] + h[j2] * a[i][j1]);
            }
        }
    }
    store(entries, times.first());
    return bits(times.some() & used);
}

/// As OrientedBoxKernel::node_on_segment().
/// @param to         the centres relative to the segment's middle
/// @param direction  the segment's
/// @param p, d       both, projected onto the boxes' axes
[[gnu::always_inline]] inline unsigned on_segment(const Vec& to, const Vec& direction, const Vec& p, const Vec& d,
                                                  const Vec& half, float margin, const SegmentLine& s,
                                                  float (&entry)[8])
{
    const F32x8 error = splat(s.error + margin);
    const F32x8 at[3] = {p.x, p.y, p.z}, along[3] = {abs(d.x), abs(d.y), abs(d.z)}, to_line[3] = {d.x, d.y, d.z},
                wide[3] = {half.x + error, half.y + error, half.z + error};
    I32x8 meets = I32x8{} == I32x8{};
    F32x8 reach = error;
#pragma GCC unroll 3
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        meets &= abs(at[i]) <= wide[i] + s.half * along[i];
        meets &= abs(at[i] * to_line[j] - at[j] * to_line[i]) <=
                 wide[i] * along[j] + wide[j] * along[i] + s.cross_error + 0.5f * margin;
        reach += wide[i] * along[i];
    }
    store(entry, s.half > 0 ? (dot(to, direction) - reach) / s.half : splat(-1));
    return bits(meets);
}

/// True if all boxes have the frame's axes.
inline bool straight(const BoxNode& node)
{
    std::uint64_t parts[6];
    __builtin_memcpy(parts, node.qx, sizeof parts); // qx, qy and qz
    return !((parts[0] | parts[1]) | (parts[2] | parts[3]) | (parts[4] | parts[5]));
}
static_assert(offsetof(BoxNode, qz) + sizeof(BoxNode::qz) - offsetof(BoxNode, qx) == 6 * sizeof(std::uint64_t));

unsigned node_on_segment(const BoxNode& node, const SegmentLine& s, float (&entry)[8])
{
    const F32x8 unit = splat(node.unit);
    const Vec to{node.origin[0] - s.middle[0] + widen(node.x) * unit,
                 node.origin[1] - s.middle[1] + widen(node.y) * unit,
                 node.origin[2] - s.middle[2] + widen(node.z) * unit};
    const Vec direction{splat(s.direction[0]), splat(s.direction[1]), splat(s.direction[2])};
    const Vec half{widen(node.hx) * unit, widen(node.hy) * unit, widen(node.hz) * unit};
    const unsigned lanes = (1u << node.lanes) - 1;
    const float margin = margin_of(node);
    if (straight(node)) return lanes & on_segment(to, direction, to, direction, half, margin, s, entry);
    Vec axes[3];
    read_axes(node, axes);
    return lanes & on_segment(to, direction, {dot(to, axes[0]), dot(to, axes[1]), dot(to, axes[2])},
                              {dot(direction, axes[0]), dot(direction, axes[1]), dot(direction, axes[2])}, half, margin,
                              s, entry);
}

} // namespace

OrientedBoxKernel oriented_box_kernel()
{
    return {open,        open_triangles, open_octants, compare_near, compare_likely,
            compare_far, reach,          from_point,   meet_in_time, node_on_segment};
}

} // namespace oncollide::ONCOLLIDE_ISA
