#include "clash/scenery.hpp"

#include <algorithm>
#include <cmath>

#include "render/framing.hpp"

namespace oncollide::tools {
namespace {

bool has_no_lines(const Clash& clash)
{
    return clash.kind == ClashKind::enclosed || clash.kind == ClashKind::duplicate;
}

/// The direction, of sixteen, from which the points spread over the largest area, preferably from above
/// and the front.
Eigen::Vector3d good_side(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& middle)
{
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& p : points) spread += (p - middle) * (p - middle).transpose();
    Eigen::Vector3d best = Eigen::Vector3d(0.45, -1, 0.45).normalized();
    if (!(spread.trace() > 0) || !spread.allFinite()) return best;
    spread /= spread.trace();
    double most = -1, later = 0;
    for (const Eigen::Vector3d& from : good_sides()) {
        const Eigen::Vector3d x = Eigen::Vector3d(0, 0, 1).cross(from).normalized(), y = from.cross(x);
        const double xx = x.dot(spread * x), yy = y.dot(spread * y), xy = x.dot(spread * y);
        // The area of the spread; for points on a line, its length.
        const double seen = std::sqrt(std::max(xx * yy - xy * xy, 0.0)) + 0.1 * (xx + yy) - later;
        later += 0.002;
        if (seen > most) most = seen, best = from;
    }
    return best;
}

} // namespace

std::vector<Contact> contacts_of(const Clashes& found, const Clash& clash)
{
    if (clash.apart() || has_no_lines(clash)) return {};
    const PairOfBodies pair = found.pair(clash);
    return found.world->pairs().contacts(pair.a, pair.b);
}

ClashScenery scenery_of(const PartList& parts, const Clash& clash, const std::vector<Contact>& contacts)
{
    constexpr std::size_t most = 100'000; // more lines would not be distinguishable
    ClashScenery s{.lines = {}, .box_a = {}, .box_b = {}, .part = clash.reach.overlap, .view = {}};
    if (clash.apart()) s.lines.push_back({clash.nearest_a, clash.nearest_b});
    for (std::size_t k = 0; k < contacts.size(); k += 1 + contacts.size() / most) s.lines.push_back(contacts[k].ends);
    std::vector<Eigen::Vector3d> points; // that the picture should show
    for (const auto& line : s.lines) points.insert(points.end(), line.begin(), line.end());
    for (const bool second : {false, true}) {
        const Part& part = parts.parts[second ? clash.b : clash.a];
        const Aabb& overlap = clash.reach.overlap;
        for (const Eigen::Vector3d& v : std::get<Mesh>(parts.meshes[part.mesh]->data).vertices) {
            const Eigen::Vector3d p = part.pose * v;
            (second ? s.box_b : s.box_a).add(p);
            if (has_no_lines(clash) && (p.array() >= overlap.min.array()).all() &&
                (p.array() <= overlap.max.array()).all())
                points.push_back(p);
        }
    }
    for (const Eigen::Vector3d& p : points) s.part.add(p);
    Aabb whole = s.box_a;
    whole.add(s.box_b);
    const double smaller = std::min(s.box_a.diagonal(), s.box_b.diagonal());
    // The camera is near enough to show the contact, far enough to recognise the parts, and not nearer than floats can
    // draw.
    const double near = std::max({0.9 * s.part.diagonal(), 0.15 * smaller, 1e-4 * whole.diagonal()});
    s.view = {good_side(points, s.part.centre()), s.part.centre(), std::min(near, 0.6 * whole.diagonal())};
    return s;
}

} // namespace oncollide::tools
