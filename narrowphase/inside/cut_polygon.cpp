#include <oncollide/narrowphase/inside/cut_polygon.hpp>

#include <algorithm>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>

namespace oncollide {

namespace {

using Eigen::Vector2d;
using Loop = std::vector<std::uint32_t>;

class Polygon {
public:
    explicit Polygon(std::span<const Vector2d> points) : points_(points) {}

    /// Joins all loops into one, which passes each connection twice; false if that fails.
    bool connect(std::vector<Loop>& loops)
    {
        const auto around = std::ranges::find_if(loops, [&](const Loop& l) { return area(l) > 0; });
        if (around == loops.end()) return false;
        loop_ = std::move(*around);
        loops.erase(around);
        const auto rightmost = [&](Loop& l) {
            return std::ranges::max_element(l, {}, [&](std::uint32_t i) { return points_[i].x(); });
        };
        for (Loop& hole : loops) {
            if (area(hole) > 0) return false;
            std::ranges::rotate(hole, rightmost(hole));
        }
        std::ranges::sort(loops, std::ranges::greater{}, [&](const Loop& l) { return points_[l[0]].x(); });
        for (std::size_t i = 0; i < loops.size(); ++i)
            if (!connect(loops[i], std::span(loops).subspan(i))) return false;
        return true;
    }

    std::optional<std::vector<Triangle>> cut()
    {
        std::vector<Triangle> triangles;
        for (std::size_t at = 0, failed = 0; loop_.size() > 3;) {
            const std::size_t n = loop_.size();
            if (failed == n) return {};
            at %= n;
            if (!is_ear(at)) {
                ++at, ++failed;
                continue;
            }
            triangles.push_back({loop_[(at + n - 1) % n], loop_[at], loop_[(at + 1) % n]});
            // The next ear is sought after this one, so that ears are cut all around.
            loop_.erase(loop_.begin() + static_cast<std::ptrdiff_t>(at)), failed = 0, ++at;
        }
        if (loop_.size() != 3 || turn(loop_[0], loop_[1], loop_[2]) <= 0) return {};
        triangles.push_back({loop_[0], loop_[1], loop_[2]});
        return triangles;
    }

private:
    int turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const
    {
        return orient2d(points_[a], points_[b], points_[c]);
    }
    double area(const Loop& loop) const
    {
        double sum = 0;
        const Vector2d& o = points_[loop[0]];
        for (std::size_t i = 2; i < loop.size(); ++i) {
            const Vector2d u = points_[loop[i - 1]] - o, v = points_[loop[i]] - o;
            sum += u.x() * v.y() - u.y() * v.x();
        }
        return sum;
    }
    /// True if a segment meets an edge elsewhere than at common corners.
    bool blocked(std::uint32_t p, std::uint32_t q, const Loop& loop) const
    {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const std::uint32_t u = loop[i], v = loop[(i + 1) % loop.size()];
            const bool at_u = u == p || u == q, at_v = v == p || v == q;
            if (at_u && at_v) return true;
            const int side_u = turn(p, q, u), side_v = turn(p, q, v);
            if (at_u || at_v) { // along the segment
                const Vector2d way = points_[q] - points_[p], other = points_[at_u ? v : u] - points_[at_u ? u : v];
                if (side_u == side_v && way.dot(other) * ((at_u ? u : v) == p ? 1 : -1) > 0) return true;
                continue;
            }
            if (side_u * side_v > 0 || turn(u, v, p) * turn(u, v, q) > 0) continue;
            if (side_u == 0 && side_v == 0) { // both ends are on the line
                const Vector2d way = points_[q] - points_[p];
                const auto at = [&](std::uint32_t w) { return way.dot(points_[w] - points_[p]); };
                if (std::max(at(u), at(v)) < 0 || std::min(at(u), at(v)) > way.squaredNorm()) continue;
            }
            return true;
        }
        return false;
    }
    /// True if a point is strictly inside the angle of a corner of the loop.
    bool in_angle(std::size_t corner, std::uint32_t p) const
    {
        const std::size_t n = loop_.size();
        const std::uint32_t before = loop_[(corner + n - 1) % n], at = loop_[corner], after = loop_[(corner + 1) % n];
        const bool left_of_first = turn(before, at, p) > 0, left_of_second = turn(at, after, p) > 0;
        return turn(before, at, after) > 0 ? left_of_first && left_of_second : left_of_first || left_of_second;
    }
    /// Connects a hole, whose first corner is its rightmost, to the nearest corner that it sees.
    bool connect(const Loop& hole, std::span<const Loop> others)
    {
        const std::uint32_t from = hole[0];
        std::vector<std::pair<double, std::size_t>> near;
        for (std::size_t i = 0; i < loop_.size(); ++i)
            near.emplace_back((points_[loop_[i]] - points_[from]).squaredNorm(), i);
        std::ranges::sort(near);
        for (const auto& [distance, number] : near) {
            const std::size_t i = number; // Clang 14 lets no lambda capture a structured binding
            if (!in_angle(i, from) || blocked(from, loop_[i], loop_)) continue;
            if (std::ranges::any_of(others, [&](const Loop& l) { return blocked(from, loop_[i], l); })) continue;
            Loop way = hole;
            way.push_back(from), way.push_back(loop_[i]);
            loop_.insert(loop_.begin() + static_cast<std::ptrdiff_t>(i) + 1, way.begin(), way.end());
            return true;
        }
        return false;
    }
    bool is_ear(std::size_t at) const
    {
        const std::size_t n = loop_.size();
        const std::uint32_t a = loop_[(at + n - 1) % n], b = loop_[at], c = loop_[(at + 1) % n];
        if (turn(a, b, c) <= 0) return false;
        return std::ranges::none_of(loop_, [&](std::uint32_t p) {
            return p != a && p != b && p != c && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
        });
    }

    std::span<const Vector2d> points_;
    Loop loop_;
};

} // namespace

std::optional<std::vector<Triangle>> cut_polygon(std::span<const Vector2d> points, std::vector<Loop> loops)
{
    Polygon polygon(points);
    if (!polygon.connect(loops)) return {};
    return polygon.cut();
}

} // namespace oncollide
