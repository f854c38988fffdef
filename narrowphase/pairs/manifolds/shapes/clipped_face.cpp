#include <oncollide/narrowphase/pairs/manifolds/shapes/clipped_face.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include <oncollide/narrowphase/pairs/manifolds/shapes/cut_polygon.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

std::uint32_t next(const ContactFace& f, std::uint32_t k)
{
    return k + 1 < f.count ? k + 1 : 0;
}

/// The outward normal of side k of a flat face, not unit, and the height of the side along it.
std::pair<Vector3d, double> side(const ContactFace& flat, std::uint32_t k, const Vector3d& along)
{
    const Vector3d out = (flat.corner[next(flat, k)] - flat.corner[k]).cross(along);
    return {out, out.dot(flat.corner[k])};
}

} // namespace

void ClippedFace::clip_segment(const ContactFace& face, const ContactFace& flat)
{
    const Vector3d from = face.corner[0], way = face.count > 1 ? Vector3d(face.corner[1] - from) : Vector3d::Zero();
    double low = 0, high = 1;
    int low_side = -1, high_side = -1;
    for (std::uint32_t k = 0; k < flat.count; ++k) {
        const auto [out, height] = side(flat, k, along_);
        const double at_low = out.dot(from) - height, rise = out.dot(way), slack = off_ * out.cwiseAbs().sum();
        if (at_low <= slack && at_low + rise <= slack) continue;
        if (at_low > slack && at_low + rise > slack) return;
        const double cut = -at_low / rise;
        if (rise < 0 ? cut > low : cut < high)
            (rise < 0 ? low : high) = cut, (rise < 0 ? low_side : high_side) = int(k);
    }
    if (low > high) return;
    const auto add = [&](double t, int by, std::uint32_t end) {
        const auto k = static_cast<std::uint32_t>(std::max(by, 0));
        corner[count++] = {from + t * way, by < 0 ? face.vertex(end) : face.edge(0, face.count - 1),
                           by < 0 ? flat.face : flat.edge(k, next(flat, k))};
    };
    add(low, low_side, 0);
    if (face.count > 1 && high > low) add(high, high_side, 1);
}

void ClippedFace::clip_polygon(const ContactFace& face, const ContactFace& flat)
{
    CutPolygon<most> polygon;
    for (std::uint32_t i = 0; i < face.count; ++i)
        polygon.add({face.corner[i], i ? int(i) - 1 : int(face.count) - 1, int(i)});
    for (std::uint32_t k = 0; k < flat.count; ++k) {
        const auto [out, level] = side(flat, k, along_);
        polygon.cut(int(k), off_ * out.cwiseAbs().sum(),
                    [&o = out, &l = level](const Vector3d& at) { return o.dot(at) - l; });
    }
    for (const auto& d : polygon.corners()) {
        Corner& to = corner[count++];
        to.at = d.at;
        const auto flat_side = [](int edge) { return static_cast<std::uint32_t>(-1 - edge); };
        if (d.before >= 0 && d.after >= 0) {
            to.of_face = face.vertex(static_cast<std::uint32_t>(d.after)), to.of_flat = flat.face;
        } else if (d.before < 0 && d.after < 0) {
            const std::uint32_t p = flat_side(d.before), q = flat_side(d.after);
            const bool adjacent = next(flat, p) == q || next(flat, q) == p;
            const std::uint32_t v = next(flat, p) == q ? q : p; // the corner between both sides
            to.of_face = face.face, to.of_flat = adjacent ? flat.vertex(v) : flat.edge(p, q);
            // Over the corner itself: the cuts of a needle's sides meet in a badly defined point.
            if (const double slope = face.normal.dot(along_); adjacent && std::abs(slope) > 0.5)
                to.at = flat.corner[v] + face.normal.dot(face.corner[0] - flat.corner[v]) / slope * along_;
        } else {
            const std::uint32_t k = flat_side(std::min(d.before, d.after));
            const auto e = static_cast<std::uint32_t>(std::max(d.before, d.after));
            to.of_face = face.edge(e, next(face, e)), to.of_flat = flat.edge(k, next(flat, k));
        }
    }
}

void ClippedFace::find(const ContactFace& face, const ContactFace& flat, const Vector3d& along, double off)
{
    count = 0, along_ = along, off_ = off;
    if (face.count < 3)
        clip_segment(face, flat);
    else
        clip_polygon(face, flat);
}

} // namespace oncollide
