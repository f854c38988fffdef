#include <oncollide/narrowphase/exact/plane_sides.hpp>

#include <algorithm>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>

namespace oncollide {

void PlaneSides::start(const TrianglePoints& plane, const Mesh& a, const Mesh& b, const RelativePose& b_to_a)
{
    plane_ = plane, a_ = &a, b_ = &b, b_to_a_ = &b_to_a;
    if (++number_ == 1u << 30) number_ = 1, of_a_.clear(), of_b_.clear();
    if (of_a_.size() < a.vertices.size()) of_a_.resize(a.vertices.size());
    if (of_b_.size() < b.vertices.size()) of_b_.resize(b.vertices.size());
}

int PlaneSides::remembered(std::vector<std::uint32_t>& sides, std::uint32_t vertex, const Eigen::Vector3d& p)
{
    const int side = orient3d(plane_[0], plane_[1], plane_[2], p);
    sides[vertex] = 4 * number_ + static_cast<std::uint32_t>(side + 1);
    return side;
}

int PlaneSides::side_of_a(std::uint32_t vertex)
{
    const std::uint32_t known = of_a_[vertex];
    return known / 4 == number_ ? int(known % 4) - 1 : remembered(of_a_, vertex, a_->vertices[vertex]);
}

int PlaneSides::side_of_b(std::uint32_t vertex)
{
    const std::uint32_t known = of_b_[vertex];
    return known / 4 == number_ ? int(known % 4) - 1 : remembered(of_b_, vertex, (*b_to_a_)(b_->vertices[vertex]));
}

bool PlaneSides::part(const Triangle& of_a, const Triangle& of_b)
{
    int side = 0; // the side of A's corners; B's are negated
    for (const std::uint32_t v : of_a) {
        const int s = side_of_a(v);
        if (s * side < 0) return false;
        side = s ? s : side;
    }
    for (const std::uint32_t v : of_b) {
        const int s = -side_of_b(v);
        if (s * side < 0) return false;
        side = s ? s : side;
    }
    return true;
}

bool PlaneSides::part_all(std::uint64_t& looked)
{
    const std::size_t of_a = a_->vertices.size(), of_b = b_->vertices.size();
    int side = 0; // the side of A's vertices; B's are negated
    // Alternates between A and B: for most planes the first vertices of A and B are on the same side, so two tests
    // suffice.
    for (std::uint32_t v = 0; v < std::max(of_a, of_b); ++v)
        for (const bool is_b : {false, true}) {
            if (v >= (is_b ? of_b : of_a)) continue;
            ++looked;
            const int s = is_b ? -side_of_b(v) : side_of_a(v);
            if (s * side < 0) return false;
            side = s ? s : side;
        }
    return true;
}

} // namespace oncollide
