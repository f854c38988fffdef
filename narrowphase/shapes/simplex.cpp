#include <oncollide/narrowphase/shapes/simplex.hpp>

#include <limits>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// The corners that the nearest point needs, and their weights.
struct Face {
    std::array<int, 3> corner;
    std::array<double, 3> weight;
    int count;
};

Face point(int i)
{
    return {{i, 0, 0}, {1, 0, 0}, 1};
}

Face nearest_on_segment(const std::array<ConvexDifference::Point, 4>& c, int i, int j)
{
    const Vector3d &p = c[i].w, d = c[j].w - p;
    const double along = -p.dot(d), length2 = d.squaredNorm();
    if (!(along > 0)) return point(i);
    if (along >= length2) return point(j);
    const double t = along / length2;
    return {{i, j, 0}, {1 - t, t, 0}, 2};
}

/// The point nearest to 0, by Ericson, "Real-Time Collision Detection", 2004, 5.1.5.
Face nearest_on_triangle(const std::array<ConvexDifference::Point, 4>& corner, int i, int j, int k)
{
    const Vector3d &a = corner[i].w, &b = corner[j].w, &c = corner[k].w;
    const Vector3d ab = b - a, ac = c - a;
    const double d1 = -ab.dot(a), d2 = -ac.dot(a);
    if (d1 <= 0 && d2 <= 0) return point(i);
    const double d3 = -ab.dot(b), d4 = -ac.dot(b);
    if (d3 >= 0 && d4 <= d3) return point(j);
    const double d5 = -ab.dot(c), d6 = -ac.dot(c);
    if (d6 >= 0 && d5 <= d6) return point(k);
    // Signed areas by cross products, which are more exact than differences of the products above.
    const Vector3d n = ab.cross(ac);
    const double vc = n.dot(a.cross(b)), va = n.dot(b.cross(c)), vb = n.dot(c.cross(a));
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return nearest_on_segment(corner, i, j);
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return nearest_on_segment(corner, i, k);
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return nearest_on_segment(corner, j, k);
    if (!(va > 0 && vb > 0 && vc > 0)) { // rounding, or no area
        const Face faces[3] = {nearest_on_segment(corner, i, j), nearest_on_segment(corner, i, k),
                               nearest_on_segment(corner, j, k)};
        const Face* best = nullptr;
        double least = std::numeric_limits<double>::infinity();
        for (const Face& f : faces) {
            Vector3d p = f.weight[0] * corner[f.corner[0]].w;
            if (f.count == 2) p += f.weight[1] * corner[f.corner[1]].w;
            if (const double d = p.squaredNorm(); d < least || !best) least = d, best = &f;
        }
        return *best;
    }
    const double sum = va + vb + vc;
    return {{i, j, k}, {va / sum, vb / sum, vc / sum}, 3};
}

} // namespace

void Simplex4::reduce()
{
    const auto take = [this](const Face& f) {
        std::array<ConvexDifference::Point, 3> kept;
        for (int i = 0; i < f.count; ++i) kept[i] = corner[f.corner[i]];
        for (int i = 0; i < f.count; ++i) corner[i] = kept[i], weight[i] = f.weight[i];
        count = f.count;
    };
    if (count == 1) {
        weight[0] = 1;
        return;
    }
    if (count == 2) return take(nearest_on_segment(corner, 0, 1));
    if (count == 3) return take(nearest_on_triangle(corner, 0, 1, 2));

    // Takes the nearest of the faces with 0 on their outer side; a face with 0 right above it is the nearest. If there
    // are none, 0 is inside. Faces at the last corner come first, as it is usually the newest.
    static constexpr int faces[4][4] = {{1, 3, 2, 0}, {0, 2, 3, 1}, {0, 3, 1, 2}, {0, 1, 2, 3}};
    Face best{};
    double least = std::numeric_limits<double>::infinity();
    std::array<double, 4> opposite{}; // volumes between 0 and each face, indexed by the corner that the face omits
    bool inside = true;
    for (const auto& [i, j, k, other] : faces) {
        const Vector3d &p = corner[i].w, n = (corner[j].w - p).cross(corner[k].w - p);
        const double zero = -n.dot(p), rest = n.dot(corner[other].w - p);
        if (rest != 0 && (zero > 0) == (rest > 0) && zero != 0) {
            opposite[other] = std::abs(zero);
            continue;
        }
        inside = false;
        const Face f = nearest_on_triangle(corner, i, j, k);
        if (f.count == 3) return take(f);
        Vector3d v = f.weight[0] * corner[f.corner[0]].w;
        for (int m = 1; m < f.count; ++m) v += f.weight[m] * corner[f.corner[m]].w;
        if (const double d = v.squaredNorm(); d < least) least = d, best = f;
    }
    if (!inside) return take(best);
    const double sum = opposite[0] + opposite[1] + opposite[2] + opposite[3];
    for (int i = 0; i < 4; ++i) weight[i] = opposite[i] / sum;
}

} // namespace oncollide
