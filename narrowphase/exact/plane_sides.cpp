#include <oncollide/narrowphase/exact/plane_sides.hpp>

#include <algorithm>
#include <span>

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

void PartingPlanes::start(const Mesh& a, const Mesh& b, const RelativePose& b_to_a)
{
    a_ = &a, b_ = &b, b_to_a_ = &b_to_a;
    added_ = 0, looked_ = 0, most_ = 8 * (a.vertices.size() + b.vertices.size()), part_all_ = false;
    tried_a_.clear(), tried_b_.clear();
}

bool PartingPlanes::part(std::uint32_t of_a, std::uint32_t of_b)
{
    return std::ranges::any_of(std::span(planes_).first(std::min(added_, planes_.size())),
                               [&](PlaneSides& plane) { return plane.part(a_->triangles[of_a], b_->triangles[of_b]); });
}

void PartingPlanes::add_new(std::uint32_t of_a, std::uint32_t of_b)
{
    if (looked_ >= most_) return;
    tried_a_.resize(a_->triangles.size()), tried_b_.resize(b_->triangles.size());
    const bool new_a = !tried_a_[of_a], new_b = !tried_b_[of_b];
    tried_a_[of_a] = tried_b_[of_b] = true;
    add(of_a, of_b, new_a, new_b);
}

void PartingPlanes::add(std::uint32_t of_a, std::uint32_t of_b, bool try_a, bool try_b)
{
    if (try_a) try_plane(corners_of(*a_, of_a), of_a, of_b);
    if (!try_b || part_all_) return;
    TrianglePoints face = corners_of(*b_, of_b);
    for (Eigen::Vector3d& p : face) p = (*b_to_a_)(p);
    try_plane(face, of_a, of_b);
}

void PartingPlanes::try_plane(const TrianglePoints& face, std::uint32_t of_a, std::uint32_t of_b)
{
    if (collinear(face[0], face[1], face[2])) return;
    PlaneSides& plane = planes_[added_ % planes_.size()];
    plane.start(face, *a_, *b_, *b_to_a_);
    if (!plane.part(a_->triangles[of_a], b_->triangles[of_b])) return;
    ++added_;
    part_all_ = looked_ < most_ && plane.part_all(looked_);
}

} // namespace oncollide
