#include <oncollide/narrowphase/overlap/cut_box.hpp>

#include <algorithm>

#include <Eigen/Geometry>

namespace oncollide {

using Eigen::Vector3d;

CutBox::CutBox(const Aabb& box)
{
    for (int axis = 0; axis < 3; ++axis)
        for (const bool high : {false, true}) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            Polygon polygon(4, high ? box.max : box.min);
            for (std::size_t k = 0; k < 4; ++k) {
                polygon[k][u] = k == 1 || k == 2 ? box.max[u] : box.min[u];
                polygon[k][v] = k >= 2 ? box.max[v] : box.min[v];
            }
            if (!high) std::ranges::reverse(polygon);
            faces_.push_back(std::move(polygon));
        }
}

void CutBox::keep(const Vector3d& normal, double from)
{
    std::vector<Polygon> kept;
    Polygon lid;
    for (const Polygon& face : faces_) {
        Polygon cut;
        for (std::size_t k = 0; k < face.size(); ++k) {
            const Vector3d &p = face[k], &q = face[(k + 1) % face.size()];
            const double at_p = normal.dot(p) - from, at_q = normal.dot(q) - from;
            if (at_p >= 0) cut.push_back(p);
            if ((at_p < 0) == (at_q < 0)) continue;
            cut.push_back(p + at_p / (at_p - at_q) * (q - p));
            lid.push_back(cut.back());
        }
        if (cut.size() > 2) kept.push_back(std::move(cut));
    }
    if (lid.size() > 2) { // the points where edges were cut, each twice, in order around their middle
        Vector3d middle = Vector3d::Zero();
        for (const Vector3d& p : lid) middle += p / double(lid.size());
        const Vector3d u = normal.unitOrthogonal(), v = u.cross(normal); // clockwise seen along the normal
        std::ranges::sort(lid, {}, [&](const Vector3d& p) {
            const Vector3d d = p - middle;
            return std::atan2(d.dot(v), d.dot(u));
        });
        kept.push_back(std::move(lid));
    }
    faces_ = std::move(kept);
}

double CutBox::volume() const
{
    if (faces_.empty()) return 0;
    const Vector3d apex = faces_[0][0];
    double volume = 0;
    for (const Polygon& face : faces_)
        for (std::size_t k = 2; k < face.size(); ++k)
            volume += (face[0] - apex).dot((face[k - 1] - apex).cross(face[k] - apex)) / 6;
    return std::max(volume, 0.0);
}

} // namespace oncollide
