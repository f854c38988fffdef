#include <oncollide/narrowphase/gl/walk/walk_shaders.hpp>

namespace oncollide::gl::walk {

// BoxNode and InnerNode, read word by word, and the arithmetic of obb/oriented_box_kernel.cpp. A driver may round in
// another order than that kernel, so pairs of boxes are rejected only beyond twice the margins that hold for it: its
// error bounds (walks/walk_frame.hpp) count operations, not their order.
const char* const box_source = R"(
float number(uint at) { return uintBitsToFloat(words[at]); }
float short_at(uint column, uint k) { return float(bitfieldExtract(int(words[column + (k >> 1u)]), int(16u * (k & 1u)), 16)); }
float ushort_at(uint column, uint k) { return float(bitfieldExtract(words[column + (k >> 1u)], int(16u * (k & 1u)), 16)); }

uint lanes_of(uint node) { return words[node + 47u] & 255u; }
bool is_leaf(uint node, uint k) { return (words[node + 47u] >> (8u + k) & 1u) != 0u; }
bool is_single(uint node, uint k) { return (words[node + 47u] >> (16u + k) & 1u) != 0u; }
bool is_inner(uint node) { return words[node + 47u] >> 24u != 0u; }
// The place in the tree's order of the first triangle of a leaf.
uint begin_of(uint node, uint k)
{
    return is_inner(node) ? words[node + 56u + k] : words[node + 44u] + (words[node + 45u] >> (4u * k) & 15u);
}
uint child_of(uint node, uint k) { return words[node + 48u + k]; } // 0: not grown; the box must be no leaf

vec3 half_of(uint node, uint k) { return vec3(ushort_at(node + 28u, k), ushort_at(node + 32u, k), ushort_at(node + 36u, k)) * number(node + 43u); }

struct Box {
    vec3 centre, axis[3], half_size;
    float margin;
};

// Box k of a node in A's frame, relative to the origin of the pair's coordinates.
Box box_of(uint pair, bool of_b, uint node, uint k)
{
    Box box;
    float unit = number(node + 43u);
    vec3 origin = vec3(number(node + 40u), number(node + 41u), number(node + 42u));
    for (int i = 0; i < 3; ++i) origin[i] -= of_b ? frames[pair].from_b[i] : frames[pair].from_a[i];
    box.centre = origin + vec3(short_at(node, k), short_at(node + 4u, k), short_at(node + 8u, k)) * unit;
    vec4 q = vec4(short_at(node + 12u, k), short_at(node + 16u, k), short_at(node + 20u, k), short_at(node + 24u, k)) * (1.0 / 32767.0);
    q *= 1.5 - 0.5 * (q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    float w = q.x, x = q.y, y = q.z, z = q.w;
    float xx = x * (x + x), yy = y * (y + y), zz = z * (z + z), xy = x * (y + y), xz = x * (z + z), yz = y * (z + z),
          wx = w * (x + x), wy = w * (y + y), wz = w * (z + z);
    box.axis[0] = vec3(1.0 - (yy + zz), xy + wz, xz - wy);
    box.axis[1] = vec3(xy - wz, 1.0 - (xx + zz), yz + wx);
    box.axis[2] = vec3(xz + wy, yz - wx, 1.0 - (xx + yy));
    box.half_size = half_of(node, k);
    box.margin = 2.0 * unit;
    if (of_b) {
        vec3 rows[3];
        for (int i = 0; i < 3; ++i)
            rows[i] = vec3(frames[pair].turn[3 * i], frames[pair].turn[3 * i + 1], frames[pair].turn[3 * i + 2]);
        vec3 c = box.centre;
        for (int i = 0; i < 3; ++i) box.centre[i] = dot(rows[i], c) + frames[pair].shift[i];
        for (int j = 0; j < 3; ++j) {
            vec3 a = box.axis[j];
            box.axis[j] = vec3(dot(rows[0], a), dot(rows[1], a), dot(rows[2], a));
        }
    }
    return box;
}

// A lower bound of the distance of two boxes: the largest gap along fifteen axes, less twice the margins. It ignores the
// rounding of the pair's placement. Stops early once it exceeds the limit.
float gap_of_boxes(Box one, Box other, float limit)
{
    vec3 d = one.centre - other.centre;
    float margin = 2.0 * (one.margin + other.margin), gap = -1e38;
    float t[3], c[3][3], a[3][3];
    for (int i = 0; i < 3; ++i) {
        t[i] = dot(other.axis[i], d);
        for (int j = 0; j < 3; ++j) {
            c[i][j] = dot(other.axis[i], one.axis[j]);
            a[i][j] = abs(c[i][j]);
        }
        gap = max(gap, abs(t[i]) - other.half_size[i] -
                           (one.half_size[0] * a[i][0] + one.half_size[1] * a[i][1] + one.half_size[2] * a[i][2]));
    }
    for (int j = 0; j < 3; ++j)
        gap = max(gap, abs(dot(one.axis[j], d)) - one.half_size[j] -
                           (other.half_size[0] * a[0][j] + other.half_size[1] * a[1][j] + other.half_size[2] * a[2][j]));
    if (gap - margin > limit) return gap - margin;
    for (int i = 0; i < 3; ++i) {
        int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            gap = max(gap, abs(t[i2] * c[i1][j] - t[i1] * c[i2][j]) -
                               (other.half_size[i1] * a[i2][j] + other.half_size[i2] * a[i1][j] +
                                one.half_size[j1] * a[i][j2] + one.half_size[j2] * a[i][j1]));
        }
    }
    return gap - margin;
}
)";

} // namespace oncollide::gl::walk
