#include <oncollide/narrowphase/gl/walk/walk_shaders.hpp>

#include <fmt/format.h>

#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>
#include <oncollide/narrowphase/gl/walk/walk_layout.hpp>

namespace oncollide::gl::walk {

namespace {

std::string constants()
{
    std::string text = "#version 430 core\n";
    const auto add = [&](const char* name, std::uint32_t value) {
        text += fmt::format("const uint {} = {}u;\n", name, value);
    };
    add("rounds", rounds), add("team_size", team), add("teams", teams), add("stack_room", stack_room);
    add("header_words", header_words), add("unsure_count", header::unsure), add("wanted_count", header::wanted);
    add("row_count", header::box_rows), add("triangle_count", header::triangles), add("dropped_count", header::dropped);
    add("queued", header::queued), add("taken", header::taken), add("groups", header::groups);
    using R = MeshWalkResult;
    add("state_met", R::state_met), add("state_open", R::state_open), add("state_unsure", R::state_unsure);
    add("state_item", R::state_item), add("most_unsure", most_unsure);
    return text;
}

constexpr const char* buffers = R"(
layout(std430, binding = 0) readonly buffer Words { uint words[]; }; // nodes, orders and corner numbers of all trees
layout(std430, binding = 1) readonly buffer Vertices { double vertices[]; };
struct Tree {
    double centre[3], radius;
    uint nodes, order, triangles, vertices, spare[4];
};
layout(std430, binding = 2) readonly buffer Trees { Tree trees[]; };
struct Pair {
    double rotation[9], translation[3]; // b into a's frame; columns
    uint tree_a, tree_b, hint_a, hint_b;
    float enough;
    uint spare[3];
};
layout(std430, binding = 3) readonly buffer Pairs { Pair pairs[]; };
struct Frame {
    double error; // of a placed coordinate, against the CPU's
    double enough;
    float turn[9], from_a[3], from_b[3], shift[3]; // as BoxPlacement
    float limit;                                   // boxes with a larger gap hold nothing near enough
    float rounding;                                // of gaps, through the placement
};
layout(std430, binding = 4) buffer Frames { Frame frames[]; };
layout(std430, binding = 5) buffer Items { uint items[]; }; // two queues
layout(std430, binding = 6) coherent buffer Results { uint results[]; };
layout(location = 0) uniform uint pair_count;
layout(location = 1) uniform uint item_room;
layout(location = 2) uniform uint unsure_room;
layout(location = 3) uniform uint wanted_room;
layout(location = 4) uniform uint round_number;
layout(location = 5) uniform uint row_limit;
layout(location = 6) uniform uint by_distance;
layout(location = 7) uniform uint most_groups;

uint result_of(uint pair) { return header_words + 4u * pair; }
uint unsure_at() { return header_words + 4u * pair_count; }
uint wanted_at() { return unsure_at() + 3u * unsure_room; }
void leave_open(uint pair) { atomicOr(results[result_of(pair)], state_open); }

// Adds an item to the queue of a round.
void add_item(uint queue, uint pair, uint a, uint b)
{
    uint at = atomicAdd(results[queued + queue], 1u);
    if (at >= item_room || queue >= rounds) {
        atomicAdd(results[dropped_count], 1u);
        leave_open(pair);
        return;
    }
    atomicAdd(results[result_of(pair)], state_item);
    if (at % teams == 0u) atomicMax(results[groups + 3u * queue], min(at / teams + 1u, most_groups));
    at = 3u * (at + (queue & 1u) * item_room);
    items[at] = pair, items[at + 1u] = a, items[at + 2u] = b;
}
// Sets the pair's result. The first meeting counts.
void set_met(uint pair, uint a, uint b)
{
    uint at = result_of(pair);
    if ((atomicOr(results[at], state_met) & state_met) != 0u) return;
    results[at + 2u] = a, results[at + 3u] = b;
}
// Adds two triangles to the list for exact arithmetic.
void add_unsure(uint pair, uint a, uint b)
{
    atomicOr(results[result_of(pair)], state_unsure);
    uint at = atomicAdd(results[unsure_count], 1u);
    if (at >= unsure_room) {
        leave_open(pair);
        return;
    }
    at = unsure_at() + 3u * at;
    results[at] = pair, results[at + 1u] = a, results[at + 2u] = b;
}
)";

constexpr const char* prepare_main = R"(
layout(local_size_x = 64) in;

double size_of(double x, double y, double z) { return abs(x) + abs(y) + abs(z); }

// As WalkFrame, with larger margins: square roots and conversions may be less exact here.
void place(uint p, out double apart_by)
{
    Pair pair = pairs[p];
    double r[9], t[3], ca[3], cb[3], d[3];
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) r[3 * i + j] = pair.rotation[3 * j + i];
        t[i] = pair.translation[i];
        ca[i] = trees[pair.tree_a].centre[i], cb[i] = trees[pair.tree_b].centre[i];
    }
    double radius_a = trees[pair.tree_a].radius, radius_b = trees[pair.tree_b].radius, both = radius_a + radius_b;
    for (int i = 0; i < 3; ++i)
        d[i] = r[3 * i] * cb[0] + (r[3 * i + 1] * cb[1] + r[3 * i + 2] * cb[2]) + t[i] - ca[i];
    double centre_b = size_of(cb[0], cb[1], cb[2]), moved_by = size_of(t[0], t[1], t[2]);
    double far = size_of(ca[0], ca[1], ca[2]) + centre_b + moved_by;
    double distance = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    double rounding = 7.7e-6LF * min(radius_a, radius_b) + 1.5e-11LF * distance + 7.2e-15LF * (distance + both + far) + 1e-30LF;
    double enough = double(pair.enough);
    apart_by = (distance * 0.9999LF - both * 1.0001LF) * 0.9999LF - rounding - enough * 1.0001LF;
    frames[p].error = 7.2e-15LF * (centre_b + radius_b + moved_by);
    frames[p].enough = enough;
    frames[p].rounding = float(rounding) * 1.0001;
    frames[p].limit = float((enough + 2.0LF * rounding) * 1.0001LF);
    bool from_a = radius_a < radius_b;
    float from_b[3];
    for (int i = 0; i < 3; ++i) {
        frames[p].from_a[i] = from_a ? 0.0 : float(d[i]);
        from_b[i] = from_a ? float(-(r[i] * d[0] + r[3 + i] * d[1] + r[6 + i] * d[2])) : 0.0;
        frames[p].from_b[i] = from_b[i];
    }
    for (int i = 0; i < 3; ++i) {
        double moved = r[3 * i] * double(from_b[0]) + r[3 * i + 1] * double(from_b[1]) + r[3 * i + 2] * double(from_b[2]);
        frames[p].shift[i] = float(d[i] + moved - (from_a ? 0.0LF : double(float(d[i]))));
        for (int j = 0; j < 3; ++j) frames[p].turn[3 * i + j] = float(r[3 * i + j]);
    }
}

void main()
{
    uint p = gl_GlobalInvocationID.x;
    if (p >= pair_count) return;
    double apart_by;
    place(p, apart_by);
    uint at = result_of(p);
    results[at] = 0u, results[at + 1u] = floatBitsToUint(1e37), results[at + 2u] = 0u, results[at + 3u] = 0u;
    if (apart_by > 0.0LF) {
        results[at + 1u] = floatBitsToUint(min(float((apart_by + double(pairs[p].enough)) * 0.9999LF), 1e36));
        return;
    }
    if (pairs[p].hint_a != 0xffffffffu) {
        float gap;
        atomicAdd(results[triangle_count], 1u);
        uint how = judge_pair(p, pairs[p].hint_a, pairs[p].hint_b, gap);
        if (how == meets) {
            set_met(p, pairs[p].hint_a, pairs[p].hint_b);
            return;
        }
        if (how == unsure) { // bodies that rest on each other: the CPU probably finds that these triangles still meet
            add_unsure(p, pairs[p].hint_a, pairs[p].hint_b), leave_open(p);
            return;
        }
    }
    add_item(0u, p, 0u, 0u);
}
)";

// A team of eight invocations walks one item depth first, as box_walk.hpp does: it opens the larger of two boxes, and
// follows the likeliest part first. A leaf is not opened. Its stack and the triangles that wait are shared. Teams take
// items until the queue is empty; every barrier is reached by all teams of a group.
constexpr const char* walk_main = R"(
layout(local_size_x = 32) in;

const uint idle = 0u, walking = 1u, finished = 2u, waiting_room = 12u, no_box = 0xffffffffu;
shared uint stack_a[teams * stack_room], stack_b[teams * stack_room];
shared uint waiting_a[teams * waiting_room], waiting_b[teams * waiting_room];
shared uint top[teams], waiting[teams], status[teams], pair_of[teams], rows[teams], tests[teams], ended[teams], tested[teams];
shared uint unsure_pairs[teams];
shared float order[teams * team_size];

void synchronise()
{
    memoryBarrierShared();
    barrier();
}

// True if nothing more is to be found: triangles met, or the CPU decides the pair.
bool is_decided(uint pair) { return (results[result_of(pair)] & (state_met | state_open)) != 0u; }

// Takes the next item whose pair is not decided yet.
void take(uint team)
{
    uint count = min(results[queued + round_number], item_room);
    for (;;) {
        uint i = atomicAdd(results[taken + round_number], 1u);
        if (i >= count) {
            status[team] = finished;
            return;
        }
        uint at = 3u * (i + (round_number & 1u) * item_room), pair = items[at];
        if (is_decided(pair)) continue;
        stack_a[team * stack_room] = items[at + 1u], stack_b[team * stack_room] = items[at + 2u];
        top[team] = 1u, waiting[team] = 0u, rows[team] = 0u, tests[team] = 0u, ended[team] = 0u, tested[team] = 0u;
        unsure_pairs[team] = 0u;
        pair_of[team] = pair, status[team] = walking;
        return;
    }
}

void test_triangles(uint pair, uint a, uint b, uint team, inout float least)
{
    float gap;
    uint how = judge_pair(pair, a, b, gap);
    if (how == meets) {
        ended[team] = 1u;
        set_met(pair, a, b);
        return;
    }
    if (may_be_near(pair, a, b, how, gap)) {
        ended[team] = 1u;
        leave_open(pair);
        return;
    }
    if (how == apart) {
        least = min(least, gap);
        return;
    }
    add_unsure(pair, a, b);
    if (atomicAdd(unsure_pairs[team], 1u) + 1u >= most_unsure) {
        ended[team] = 1u;
        leave_open(pair);
    }
}

void want(uint pair, uint tree, uint node, uint box)
{
    leave_open(pair);
    uint at = atomicAdd(results[wanted_count], 1u);
    if (at >= wanted_room) return;
    at = wanted_at() + 3u * at;
    results[at] = tree, results[at + 1u] = node, results[at + 2u] = box;
}

uint triangle_at(uint tree, uint place) { return words[trees[tree].order + place]; }

void main()
{
    uint lane = gl_LocalInvocationID.x % team_size, team = gl_LocalInvocationID.x / team_size;
    uint base = team * stack_room;
    float least = 1e37;
    if (lane == 0u) status[team] = idle;
    for (;;) {
        if (lane == 0u) {
            if (status[team] == walking && (ended[team] != 0u || ((rows[team] & 3u) == 3u && is_decided(pair_of[team]))))
                top[team] = 0u, waiting[team] = 0u;
            if (status[team] == idle) take(team);
        }
        synchronise();
        bool some = false;
        for (uint i = 0u; i < teams; ++i) some = some || status[i] != finished;
        uint my_top = top[team], my_waiting = waiting[team], pair = pair_of[team], my_rows = rows[team];
        bool runs = status[team] == walking, full = my_rows >= row_limit, first = tested[team] == 0u;
        synchronise();
        if (!some) break;
        bool test = runs && my_waiting > 0u && (my_waiting >= (first ? 4u : 8u) || my_top == 0u || full);
        bool leave = runs && !test && full && my_top > 0u;
        bool step = runs && !test && !leave && my_top > 0u;
        bool ends = runs && !test && !step && (leave || my_waiting == 0u);
        if (test) {
            uint count = min(my_waiting, team_size);
            uint at = team * waiting_room + my_waiting - 1u - lane;
            if (lane < count) test_triangles(pair, waiting_a[at], waiting_b[at], team, least);
            if (lane == 0u) waiting[team] = my_waiting - count, tests[team] += count, tested[team] = 1u;
        }
        if (leave)
            for (uint i = lane; i < my_top; i += team_size) add_item(round_number + 1u, pair, stack_a[base + i], stack_b[base + i]);
        if (ends) {
            if (least < 1e37) atomicMin(results[result_of(pair) + 1u], floatBitsToUint(least));
            least = 1e37;
            if (lane == 0u) {
                atomicAdd(results[row_count], my_rows), atomicAdd(results[triangle_count], tests[team]);
                atomicAdd(results[result_of(pair)], 0u - state_item);
                status[team] = idle;
            }
        }

        // One step: my box of the opened node, if it is near enough.
        uint my_a = no_box, my_b = no_box;
        float my_order = 1e38;
        uint tree_a = pairs[pair].tree_a, tree_b = pairs[pair].tree_b, pushed_triangles = 0u;
        bool opens = false;
        if (step) {
            uint a = stack_a[base + my_top - 1u], b = stack_b[base + my_top - 1u];
            uint node_a = trees[tree_a].nodes + 16u * (a >> 3u), node_b = trees[tree_b].nodes + 16u * (b >> 3u);
            uint box_a = a & 7u, box_b = b & 7u;
            bool leaf_a = is_leaf(node_a, box_a), leaf_b = is_leaf(node_b, box_b);
            if (leaf_a && leaf_b) {
                uint count_a = is_single(node_a, box_a) ? 1u : 2u, count_b = is_single(node_b, box_b) ? 1u : 2u;
                pushed_triangles = count_a * count_b;
                if (lane < pushed_triangles) {
                    uint at = team * waiting_room + my_waiting + lane;
                    waiting_a[at] = triangle_at(tree_a, begin_of(node_a, box_a) + lane % count_a);
                    waiting_b[at] = triangle_at(tree_b, begin_of(node_b, box_b) + lane / count_a);
                }
            } else {
                vec3 half_a = half_of(node_a, box_a), half_b = half_of(node_b, box_b);
                bool opens_a = leaf_b || (!leaf_a && dot(half_a, half_a) >= dot(half_b, half_b));
                uint child = opens_a ? child_of(node_a, box_a) : child_of(node_b, box_b);
                opens = child != 0u;
                if (!opens) {
                    if (lane == 0u) {
                        want(pair, opens_a ? tree_a : tree_b, (opens_a ? a : b) >> 3u, (opens_a ? a : b) & 7u);
                        ended[team] = 1u;
                    }
                } else {
                    uint node = trees[opens_a ? tree_a : tree_b].nodes + 16u * child;
                    if (lane < lanes_of(node)) {
                        Box part = box_of(pair, !opens_a, node, lane);
                        Box other = box_of(pair, opens_a, opens_a ? node_b : node_a, opens_a ? box_b : box_a);
                        float gap = gap_of_boxes(part, other, frames[pair].limit);
                        if (gap > frames[pair].limit) {
                            least = min(least, (gap - frames[pair].rounding) * 0.9999);
                        } else {
                            vec3 d = part.centre - other.centre;
                            my_order = gap + 2.0 * sqrt(dot(d, d));
                            my_a = opens_a ? child << 3u | lane : a, my_b = opens_a ? b : child << 3u | lane;
                        }
                    }
                }
            }
        }
        order[gl_LocalInvocationID.x] = my_order;
        synchronise();
        if (step) {
            uint count = 0u, above = 0u; // boxes to follow, and those of them that are followed after mine
            for (uint i = 0u; i < team_size; ++i) {
                float other = order[team * team_size + i];
                if (other == 1e38) continue;
                ++count;
                if (other > my_order || (other == my_order && i > lane)) ++above;
            }
            if (my_a != no_box) {
                uint at = my_top - 1u + above;
                if (at < stack_room)
                    stack_a[base + at] = my_a, stack_b[base + at] = my_b;
                else
                    add_item(round_number + 1u, pair, my_a, my_b);
            }
            if (lane == 0u) {
                top[team] = min(my_top - 1u + count, stack_room);
                waiting[team] = my_waiting + pushed_triangles;
                rows[team] = my_rows + (opens ? 1u : 0u);
            }
        }
    }
}
)";

} // namespace

std::string WalkShaders::prepare()
{
    return constants() + buffers + triangle_source + prepare_main;
}
std::string WalkShaders::walk()
{
    return constants() + buffers + box_source + triangle_source + walk_main;
}

} // namespace oncollide::gl::walk
