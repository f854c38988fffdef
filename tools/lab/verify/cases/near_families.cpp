#include "verify/cases/near_families.hpp"

#include <algorithm>

namespace oncollide {
namespace {

using Eigen::Vector3d;

/// An orthonormal frame in a random direction.
struct Axes {
    Vector3d x, y, z;
    explicit Axes(CaseNumbers& draw)
    {
        const Eigen::Matrix3d r = draw.rotation();
        x = r.col(0), y = r.col(1), z = r.col(2);
    }
};

TwoTriangles in_random_order(CaseNumbers& draw, const TrianglePoints& a, const TrianglePoints& b)
{
    const auto turned = [&](TrianglePoints t) {
        std::rotate(t.begin(), t.begin() + draw.number(0, 2), t.end());
        if (draw.number(0, 1)) std::swap(t[0], t[1]);
        return t;
    };
    return draw.number(0, 1) ? TwoTriangles(turned(b), turned(a)) : TwoTriangles(turned(a), turned(b));
}

TwoTriangles needles_in_line(CaseNumbers& draw)
{
    const Axes axes(draw);
    const auto needle = [&](const Vector3d& from, const Vector3d& along) {
        const double thick = draw.magnitude(-50, -8);
        return TrianglePoints{from, from + along, from + draw.real(-0.2, 1.2) * along + thick * draw.vector()};
    };
    const Vector3d tilted = axes.x + draw.magnitude(-50, -3) * draw.vector();
    const Vector3d from = draw.real(-0.5, 1.5) * axes.x + draw.magnitude(-50, -5) * draw.vector();
    return in_random_order(draw, needle(Vector3d::Zero(), axes.x), needle(from, tilted));
}

/// A corner above the middle of a sliver.
TwoTriangles peak_above_sliver(CaseNumbers& draw)
{
    const Axes axes(draw);
    const double thick = draw.magnitude(-40, -4), height = thick * draw.magnitude(-20, 4),
                 middle = draw.real(-0.9, 0.9);
    const TrianglePoints sliver{-axes.x, axes.x, middle * axes.x + thick * axes.y};
    const Vector3d p =
        (middle + draw.real(-0.05, 0.05)) * axes.x + draw.real(-0.5, 1.2) * thick * axes.y + height * axes.z;
    const double size = draw.magnitude(-8, 1);
    return in_random_order(draw, sliver,
                           {p, p + size * (axes.z + 0.4 * draw.vector()), p + size * (axes.z + 0.4 * draw.vector())});
}

/// Two roofs whose ridges cross at a small angle.
TwoTriangles edges_nearly_parallel(CaseNumbers& draw)
{
    const Axes axes(draw);
    const double angle = draw.magnitude(-50, -2), height = draw.magnitude(-50, -1);
    const Vector3d along = axes.x + draw.sign() * angle * axes.y;
    const Vector3d at = draw.real(-1.2, 1.2) * axes.x + height * axes.z;
    const Vector3d begin = at - draw.real(0.1, 1) * along, end = at + draw.real(0.1, 1) * along;
    return in_random_order(draw, {-axes.x, axes.x, -axes.z + 0.5 * draw.vector()},
                           {begin, end, at + axes.z + 0.5 * draw.vector()});
}

TwoTriangles faces_nearly_parallel(CaseNumbers& draw)
{
    const Axes axes(draw);
    const double tilt = draw.magnitude(-50, -2), height = draw.magnitude(-50, -1);
    const auto flat = [&](double up, double size) {
        return Vector3d(size * (draw.real(-1, 1) * axes.x + draw.real(-1, 1) * axes.y) + up * axes.z);
    };
    const double size = draw.magnitude(-6, 2);
    const auto above = [&] { return flat(height + draw.number(0, 1) * tilt * draw.real(0, 1), size); };
    return in_random_order(draw, {flat(0, 1), flat(0, 1), flat(0, 1)}, {above(), above(), above()});
}

/// A triangle with an angle of nearly 180 degrees, and a corner or an edge near that corner.
TwoTriangles cap_and_corner(CaseNumbers& draw)
{
    const Axes axes(draw);
    const double flat = draw.magnitude(-45, -4), away = draw.magnitude(-50, -2);
    const Vector3d tip = draw.real(-0.9, 0.9) * axes.x + flat * axes.y;
    const Vector3d p = tip + away * draw.vector();
    return in_random_order(draw, {-axes.x, axes.x, tip},
                           {p, p + draw.magnitude(-6, 1) * draw.vector(), p + draw.magnitude(-6, 1) * draw.vector()});
}

TwoTriangles corner_nearly_shared(CaseNumbers& draw)
{
    const TrianglePoints a{draw.vector(), draw.vector(), draw.vector()};
    const Vector3d p = a[0] + draw.magnitude(-50, -4) * draw.vector();
    return in_random_order(draw, a, {p, p + draw.vector(), p + draw.magnitude(-20, 0) * draw.vector()});
}

TwoTriangles edge_nearly_shared(CaseNumbers& draw)
{
    const TrianglePoints a{draw.vector(), draw.vector(), draw.vector()};
    const double off = draw.magnitude(-50, -4);
    return in_random_order(draw, a, {a[0] + off * draw.vector(), a[1] + off * draw.vector(), draw.vector()});
}

TwoTriangles sizes_far_apart(CaseNumbers& draw)
{
    const TrianglePoints a{draw.vector(), draw.vector(), draw.vector()};
    const double u = draw.real(-0.2, 1.2), v = draw.real(-0.2, 1.2), size = draw.magnitude(-40, 20);
    const Vector3d p = a[0] + u * (a[1] - a[0]) + v * (a[2] - a[0]) + draw.magnitude(-50, 0) * draw.vector();
    return in_random_order(draw, a, {p, p + size * draw.vector(), p + size * draw.vector()});
}

TwoTriangles at_random(CaseNumbers& draw)
{
    const Vector3d shift = draw.real(0, 2) * draw.vector();
    return {{draw.vector(), draw.vector(), draw.vector()},
            {draw.vector() + shift, draw.vector() + shift, draw.vector() + shift}};
}

} // namespace

const std::vector<NearFamily>& near_families()
{
    static const std::vector<NearFamily> all{{"near needles in line", needles_in_line},
                                             {"near peak above sliver", peak_above_sliver},
                                             {"near edges almost parallel", edges_nearly_parallel},
                                             {"near faces almost parallel", faces_nearly_parallel},
                                             {"near cap and corner", cap_and_corner},
                                             {"near corners", corner_nearly_shared},
                                             {"near edges", edge_nearly_shared},
                                             {"near, sizes far apart", sizes_far_apart},
                                             {"near, at random", at_random}};
    return all;
}

TwoTriangles draw_near(const NearFamily& family, std::uint64_t number)
{
    CaseNumbers draw(number * 0x9e3779b97f4a7c15u + 1);
    TwoTriangles pair = family.make(draw);
    double scale = draw.number(0, 3) ? std::ldexp(1.0, draw.number(-30, 28)) : 1;
    const Vector3d far =
        draw.number(0, 3) ? Vector3d(Vector3d::Zero()) : Vector3d(draw.magnitude(0, 16) * draw.vector());
    double most = 0;
    for (const TrianglePoints* t : {&pair.first, &pair.second})
        for (const Vector3d& p : *t) most = std::max(most, (p + far).cwiseAbs().maxCoeff());
    if (scale * most > 1e15) scale = 1; // a World takes no coordinates beyond
    for (TrianglePoints* t : {&pair.first, &pair.second})
        for (Vector3d& p : *t) p = scale * (p + far);
    return pair;
}

} // namespace oncollide
