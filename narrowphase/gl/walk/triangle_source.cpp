#include <oncollide/narrowphase/gl/walk/walk_shaders.hpp>

namespace oncollide::gl::walk {

// Guigue and Devillers' test, as in exact/kernels/triangle_kernel.cpp. Certain results hold for the coordinates that
// RelativePose gives on the CPU, though the GPU may round differently: each coordinate of B's corners, as the GPU
// places them, errs by at most `error` (prepare_main). Let X, Y, Z be the sides of the common box of both triangles,
// each plus 2 error + 2^-300. The six products of a determinant change by at most 6 ((X + 2e)(Y + 2e)(Z + 2e) - XYZ),
// which is below 13 e (XY + YZ + ZX) for the larger sides, and its rounding is below 56 u XYZ, u = 2^-53, in any order
// of operations, fused or not. A component of an axis changes by at most 8 e (X + Y + Z) and rounds by 2^-49 (XY + YZ +
// ZX).
const char* const triangle_source = R"(
struct Corners { dvec3 p, q, r; };

const uint apart = 0u, meets = 1u, unsure = 2u;

dvec3 across(dvec3 u, dvec3 v) { return dvec3(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x); }
double along(dvec3 u, dvec3 v) { return u.x * v.x + u.y * v.y + u.z * v.z; }

dvec3 vertex(uint tree, uint number)
{
    uint at = 3u * (trees[tree].vertices + number);
    return dvec3(vertices[at], vertices[at + 1u], vertices[at + 2u]);
}
Corners corners(uint tree, uint triangle)
{
    uint at = trees[tree].triangles + 3u * triangle;
    return Corners(vertex(tree, words[at]), vertex(tree, words[at + 1u]), vertex(tree, words[at + 2u]));
}
dvec3 placed(uint pair, dvec3 p)
{
    dvec3 q;
    for (int i = 0; i < 3; ++i)
        q[i] = pairs[pair].rotation[i] * p.x +
               (pairs[pair].rotation[3 + i] * p.y + pairs[pair].rotation[6 + i] * p.z) + pairs[pair].translation[i];
    return q;
}

// -1, 1: certainly below or above; 0: not certain.
ivec3 sides_of(dvec3 heights, double bound)
{
    return ivec3(heights.x > bound ? 1 : heights.x < -bound ? -1 : 0, heights.y > bound ? 1 : heights.y < -bound ? -1 : 0,
                 heights.z > bound ? 1 : heights.z < -bound ? -1 : 0);
}
bool on_one_side(ivec3 s) { return s.x != 0 && s.x == s.y && s.x == s.z; }
bool known(ivec3 s) { return s.x != 0 && s.y != 0 && s.z != 0; }
// The least height of corners on one side.
double beyond(dvec3 h) { return max(min(min(h.x, h.y), h.z), -max(max(h.x, h.y), h.z)); }

// Moves the corner that is alone on its side to the first position. Returns its side.
int turn(inout Corners t, ivec3 s)
{
    if (s.x == s.y) {
        t = Corners(t.r, t.p, t.q);
        return s.z;
    }
    if (s.x == s.z) {
        t = Corners(t.q, t.r, t.p);
        return s.y;
    }
    return s.x;
}

// A lower bound of a distance: a determinant over the length of its axis.
float gap_of(double height, dvec3 axis, double axis_error)
{
    double squared = height * height / (along(axis, axis) * 1.001953125LF + axis_error * axis_error * 4096.0LF + 1e-280LF);
    if (!(squared > 1e-60LF)) return 0.0;
    return squared < 1e60LF ? float(sqrt(squared)) * 0.999 : 1e30;
}

// How a and b, both in A's frame, lie. gap: if apart, a lower bound of their distance, > 0.
uint judge(Corners a, Corners b, double error, out float gap)
{
    gap = 0.0;
    dvec3 lo_a = min(min(a.p, a.q), a.r), hi_a = max(max(a.p, a.q), a.r);
    dvec3 lo_b = min(min(b.p, b.q), b.r), hi_b = max(max(b.p, b.q), b.r);
    dvec3 between = max(lo_b - hi_a, lo_a - hi_b);
    double widest = max(max(between.x, between.y), between.z);
    if (widest > 4.0LF * error) { // also in one plane, where the other tests are not certain
        gap = float(widest) * 0.999;
        return gap > 0.0 ? apart : unsure;
    }
    dvec3 lo = min(lo_a, lo_b), hi = max(hi_a, hi_b);
    dvec3 side = hi - lo + (2.0LF * error + 4.9e-91LF);
    double faces = side.x * side.y + side.y * side.z + side.z * side.x;
    double bound = side.x * side.y * side.z * 7.2e-15LF + 16.0LF * error * faces;
    double axis_error = faces * 2e-15LF + 16.0LF * error * (side.x + side.y + side.z);

    dvec3 normal = across(a.q - a.p, a.r - a.p);
    dvec3 heights = dvec3(along(normal, b.p - a.p), along(normal, b.q - a.p), along(normal, b.r - a.p));
    ivec3 of_b = sides_of(heights, bound);
    if (on_one_side(of_b)) {
        gap = gap_of(beyond(heights) - bound, normal, axis_error);
        return gap > 0.0 ? apart : unsure;
    }
    normal = across(b.q - b.p, b.r - b.p);
    heights = dvec3(along(normal, a.p - b.p), along(normal, a.q - b.p), along(normal, a.r - b.p));
    ivec3 of_a = sides_of(heights, bound);
    if (on_one_side(of_a)) {
        gap = gap_of(beyond(heights) - bound, normal, axis_error);
        return gap > 0.0 ? apart : unsure;
    }
    if (!known(of_a) || !known(of_b)) return unsure;
    int lone_a = turn(a, of_a), lone_b = turn(b, of_b);
    dvec3 w = b.p - a.p, t = b.q - b.p, u = b.r - b.p;
    bool alike = lone_a == lone_b;
    if (!alike) {
        dvec3 other = t;
        t = u, u = other;
    }
    dvec3 first_axis = across(a.q - a.p, t), second_axis = across(a.r - a.p, u);
    double first = along(first_axis, w), second = along(second_axis, w);
    if (lone_b < 0) first = -first, second = -second;
    if (first < -bound) {
        gap = gap_of(-first - bound, first_axis, axis_error);
        return gap > 0.0 ? apart : unsure;
    }
    if (second > bound) {
        gap = gap_of(second - bound, second_axis, axis_error);
        return gap > 0.0 ? apart : unsure;
    }
    return first > bound && second < -bound ? meets : unsure;
}

float squared_corner_distance(Corners a, Corners b)
{
    dvec3 p[3] = dvec3[3](a.p, a.q, a.r), q[3] = dvec3[3](b.p, b.q, b.r);
    double least = 1e300LF;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            dvec3 d = p[i] - q[k];
            least = min(least, along(d, d));
        }
    return least < 1e36LF ? float(least) : 1e36;
}

// As judge(), for two triangles of a pair. gap: of the bodies, in the world.
uint judge_pair(uint pair, uint a, uint b, out float gap)
{
    Corners of_a = corners(pairs[pair].tree_a, a), of_b = corners(pairs[pair].tree_b, b);
    of_b = Corners(placed(pair, of_b.p), placed(pair, of_b.q), placed(pair, of_b.r));
    float error = float(frames[pair].error) * 2.5;
    uint how = judge(of_a, of_b, frames[pair].error, gap);
    if (how == apart) gap = max(gap - error, min(gap, error)) * 0.9999;
    return how;
}
// True if two triangles of a pair, which do not certainly meet, may be near enough for the pair to stay open.
bool may_be_near(uint pair, uint a, uint b, uint how, float gap)
{
    float enough = float(frames[pair].enough);
    if (enough == 0.0) return false;
    if (how != apart) return true;
    if (by_distance != 0u) return gap <= enough * 1.001;
    Corners of_a = corners(pairs[pair].tree_a, a), of_b = corners(pairs[pair].tree_b, b);
    of_b = Corners(placed(pair, of_b.p), placed(pair, of_b.q), placed(pair, of_b.r));
    float far = enough * 1.001 + float(frames[pair].error) * 8.0;
    return squared_corner_distance(of_a, of_b) <= far * far * 1.001;
}
)";

} // namespace oncollide::gl::walk
