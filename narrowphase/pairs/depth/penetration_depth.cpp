#include <oncollide/narrowphase/pairs/penetration_depth.hpp>

#include <algorithm>
#include <numeric>
#include <queue>

#include <oncollide/narrowphase/pairs/depth_bounds.hpp>

namespace oncollide {

namespace {

constexpr std::uint8_t unknown = 0, outside = 1, inside = 2;

/// Bounding box of the contacts.
Aabb box_of(std::span<const Contact> contacts)
{
    Aabb box;
    for (const Contact& contact : contacts)
        for (const Eigen::Vector3d& end : contact.ends) box.add(end);
    return box;
}

/// Directions along which an overlap may be thin: the axes and the distinct normals of contacts.
std::vector<Eigen::Vector3d> directions_of(std::span<const Contact> contacts)
{
    constexpr std::size_t most = 16;
    std::vector<Eigen::Vector3d> directions{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                            Eigen::Vector3d::UnitZ()};
    for (const Contact& contact : contacts)
        for (const Eigen::Vector3d& normal : {contact.normal_a, contact.normal_b}) {
            if (directions.size() == most) return directions;
            if (normal.isZero()) continue;
            if (std::ranges::none_of(directions, [&](const auto& d) { return std::abs(d.dot(normal)) > 1 - 1e-6; }))
                directions.push_back(normal);
        }
    return directions;
}

double width_along(const Eigen::Vector3d& direction, std::span<const Eigen::Vector3d> points)
{
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const Eigen::Vector3d& point : points) {
        const double at = direction.dot(point);
        least = std::min(least, at), most = std::max(most, at);
    }
    return std::max(most - least, 0.0);
}

} // namespace

std::uint32_t PenetrationDepth::root_of(std::uint32_t vertex)
{
    while (roots_[vertex] != vertex) vertex = roots_[vertex] = roots_[roots_[vertex]];
    return vertex;
}

/// Stores the vertices of `inner` inside `outer` in inside_ and points_. Vertices connected by triangles that do not
/// meet the other surface are all on the same side of it, so one vertex per such component is located.
void PenetrationDepth::find_inside(const Side& inner, const Side& outer, std::span<const std::uint8_t> meets)
{
    inside_.clear(), points_.clear();
    if (!outer.model->has_inside()) return;
    const Mesh& mesh = *inner.model->surface_mesh();
    const Mesh& around = *outer.model->surface_mesh();
    roots_.resize(mesh.vertices.size());
    std::iota(roots_.begin(), roots_.end(), 0u);
    std::vector<std::uint8_t> used(mesh.vertices.size(), 0);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& triangle = mesh.triangles[t];
        for (const std::uint32_t v : triangle) used[v] = 1;
        if (meets[t]) continue;
        for (const std::size_t k : {1, 2}) roots_[root_of(triangle[k])] = root_of(triangle[0]);
    }
    // A component with a vertex outside the other's box is outside.
    Aabb box;
    for (unsigned k = 0; k < 8; ++k) box.add(outer.to_a(corner_of(around.bounds, k)));
    const double slack = 0x1p-30 * (box.diagonal() + box.min.cwiseAbs().maxCoeff() + box.max.cwiseAbs().maxCoeff());
    std::vector<std::uint8_t> place(mesh.vertices.size(), unknown); // by root
    const auto beyond = [&](const Eigen::Vector3d& p) {
        return (p.array() < box.min.array() - slack).any() || (p.array() > box.max.array() + slack).any();
    };
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
        if (used[v] && beyond(inner.to_a(mesh.vertices[v]))) place[root_of(v)] = outside;
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
        if (!used[v]) continue;
        std::uint8_t& here = place[root_of(v)];
        if (here == outside) continue;
        const Eigen::Vector3d point = inner.to_a(mesh.vertices[v]);
        if (here == unknown)
            here = locator_->place(point, around, outer.model->obb_tree(), outer.to_a) == PointLocation::inside
                       ? inside
                       : outside;
        if (here == inside) inside_.push_back(v), points_.push_back(point);
    }
}

Distance PenetrationDepth::to_surface(const Side& outer, const Eigen::Vector3d& point)
{
    Mesh mesh{.vertices = {point}, .triangles = {{0, 0, 0}}, .bounds = {}, .zero_area = 1};
    mesh.bounds.add(point);
    ObbTree tree(mesh);
    const auto found = walk_->distance(tree, *outer.model->obb_tree(), outer.to_a, 0);
    return {.lower = found.lower, .upper = found.upper};
}

/// Finds the deepest of points_ by branch and bound: sets of vertices are halved, best upper bound first. The upper
/// bound of a set is the depth of one vertex plus its largest distance to another.
void PenetrationDepth::find_deepest(const Side& outer, bool of_a, Penetration& found)
{
    struct Set {
        double most; ///< upper bound on the depth of its vertices
        std::uint32_t begin, end;
        bool operator<(const Set& other) const { return most < other.most; }
    };
    std::vector<std::uint32_t> order(points_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::priority_queue<Set> sets;
    const auto look_at = [&](std::uint32_t begin, std::uint32_t end) {
        const auto members = std::span(order).subspan(begin, end - begin);
        Aabb box;
        for (const std::uint32_t i : members) box.add(points_[i]);
        const auto from_middle = [&](std::uint32_t i) { return (points_[i] - box.centre()).squaredNorm(); };
        const std::uint32_t tried = std::ranges::min(members, {}, from_middle);
        double farthest = 0;
        for (const std::uint32_t i : members) farthest = std::max(farthest, (points_[i] - points_[tried]).norm());
        const Distance d = to_surface(outer, points_[tried]);
        if (d.lower > found.depth) {
            found.depth = d.lower, found.of_a = of_a, found.vertex = inside_[tried];
            found.deepest = points_[tried];
        }
        if (end - begin > 1) sets.push({d.upper + farthest, begin, end});
    };
    if (!order.empty()) look_at(0, static_cast<std::uint32_t>(order.size()));
    constexpr double enough = 1.01;
    while (!sets.empty() && sets.top().most > enough * found.depth) {
        const auto [most, begin, end] = sets.top();
        sets.pop();
        Aabb box;
        for (std::uint32_t k = begin; k < end; ++k) box.add(points_[order[k]]);
        Eigen::Index axis = 0;
        box.half_extent().maxCoeff(&axis);
        const std::uint32_t half = begin + (end - begin) / 2;
        std::nth_element(order.begin() + begin, order.begin() + half, order.begin() + end,
                         [&](std::uint32_t i, std::uint32_t j) {
                             return std::pair(points_[i][axis], i) < std::pair(points_[j][axis], j);
                         });
        look_at(begin, half), look_at(half, end);
    }
}

Penetration PenetrationDepth::measure(const PairTask& task, std::span<const Contact> contacts, PointLocator& locator,
                                      Traversal& walk)
{
    locator_ = &locator, walk_ = &walk;
    const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
    const Side a{task.a, RelativePose(here, here)}, b{task.b, RelativePose(*task.pose_a, *task.pose_b)};
    Penetration found;
    found.contact = found.overlap = box_of(contacts);
    all_.clear();
    for (const Contact& contact : contacts) all_.insert(all_.end(), contact.ends.begin(), contact.ends.end());
    for (const bool of_a : {true, false}) {
        const Side &inner = of_a ? a : b, &outer = of_a ? b : a;
        meets_.assign(inner.model->surface_mesh()->triangles.size(), 0);
        for (const Contact& contact : contacts) meets_[of_a ? contact.a.triangle : contact.b.triangle] = 1;
        find_inside(inner, outer, meets_);
        for (const Eigen::Vector3d& point : points_) {
            all_.push_back(*task.pose_a * point);
            found.overlap.add(all_.back());
        }
        find_deepest(outer, of_a, found);
    }
    if (found.depth > 0) found.deepest = *task.pose_a * found.deepest;
    if (!contacts.empty() || found.depth > 0) found.depth_upper = parting_translation(task, directions_of(contacts));
    if (task.a->has_inside() && task.b->has_inside())
        for (const Eigen::Vector3d& direction : directions_of(contacts))
            if (const double width = width_along(direction, all_); width < found.thickness)
                found.thickness = width, found.thin_along = direction;
    return found;
}

} // namespace oncollide
