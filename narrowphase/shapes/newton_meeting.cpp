#include <oncollide/narrowphase/shapes/newton_meeting.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace oncollide {

namespace {

using Eigen::Vector3d;

constexpr int most_looks = 8;

/// Two unit directions orthogonal to a third and to each other. Source: Duff et al., "Building an orthonormal basis,
/// revisited", JCGT 2017.
std::pair<Vector3d, Vector3d> across(const Vector3d& n)
{
    const double sign = std::copysign(1.0, n.z()), a = -1 / (sign + n.z()), b = n.x() * n.y() * a;
    return {{1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x()}, {b, sign + n.y() * n.y() * a, -n.y()}};
}

/// Second derivatives of support functions, orthogonal to a direction.
struct Curvature {
    double ee = 0, ef = 0, ff = 0;
    int rank = 0;

    /// Adds the core's derivatives at d along e and f, which are orthogonal to d.
    void add(const Convex& c, const Vector3d& d, const Vector3d& e, const Vector3d& f)
    {
        if (c.core == Convex::Core::ellipsoid) {
            const Vector3d s = c.high.cwiseProduct(d), es = c.high.cwiseProduct(e), fs = c.high.cwiseProduct(f);
            const double length = s.norm(), by_e = s.dot(es) / length, by_f = s.dot(fs) / length;
            ee += (es.squaredNorm() - by_e * by_e) / length, ff += (fs.squaredNorm() - by_f * by_f) / length;
            ef += (es.dot(fs) - by_e * by_f) / length;
            rank += 2;
            return;
        }
        const double rho2 = d.x() * d.x() + d.y() * d.y(), rho = std::sqrt(rho2);
        const bool apex = c.core == Convex::Core::cone && 2 * c.high.z() * d.z() >= c.high.x() * rho;
        if (apex || !(rho > 1e-9)) return;
        const double along_e = d.x() * e.y() - d.y() * e.x(), along_f = d.x() * f.y() - d.y() * f.x();
        const double scale = c.high.x() / (rho2 * rho);
        ee += scale * along_e * along_e, ef += scale * along_e * along_f, ff += scale * along_f * along_f;
        ++rank;
    }
};

} // namespace

Vector3d newton_step(const ConvexDifference& cores, const Vector3d& n, const Vector3d& w)
{
    const Convex &a = cores.a(), &b = cores.b();
    const double damping = 1e-5 * cores.size(), stiffness = 0.1 * cores.size();
    const auto [e, f] = across(n);
    Curvature h;
    if (!a.flat_sided) h.add(a, n, e, f);
    if (!b.flat_sided) h.add(b, -cores.into_b(n), cores.into_b(e), cores.into_b(f));
    if (const double trace = h.ee + h.ff; h.rank == 1 && trace > 0) { // no large steps where the surface is flat
        const double scale = stiffness / trace, ee = h.ee;
        h.ee += scale * h.ff, h.ff += scale * ee, h.ef -= scale * h.ef;
    }
    const double more = std::max(n.dot(w), 0.0) + damping;
    h.ee += more, h.ff += more;
    const double by_e = e.dot(w), by_f = f.dot(w), det = h.ee * h.ff - h.ef * h.ef;
    const Vector3d step = ((h.ff * by_e - h.ef * by_f) * e + (h.ee * by_f - h.ef * by_e) * f) / det;
    const double steps = step.norm();
    return steps > 1 ? Vector3d(step / steps) : step;
}

NewtonMeeting newton_meeting(const ConvexDifference& cores)
{
    const Convex &a = cores.a(), &b = cores.b();
    const double radius = cores.radius();
    NewtonMeeting found;
    found.meeting = {0, 0}, found.direction = cores.middle();
    Vector3d& n = found.direction;
    double last = -std::numeric_limits<double>::infinity();
    for (found.looks = 1;; ++found.looks) {
        if (const double length = n.norm(); length > 0)
            n /= length;
        else
            n = Vector3d::UnitX();
        ConvexDifference::Point& p = found.looks == 1 ? found.first : found.last;
        p = cores.support(-n);
        const double apart = n.dot(p.w);
        if (const double gap = apart - radius - cores.rounding(); gap > 0) {
            found.meeting = {1, gap};
            break;
        }
        if (cores.one_holds(p.a + a.radius * n, p.a + p.w - b.radius * n)) {
            found.meeting = {-1, 0};
            break;
        }
        if (!(apart > last) || found.looks == most_looks || cores.flat_sided()) break; // faces or edges: Portal decides
        last = apart;
        n += newton_step(cores, n, p.w);
    }
    return found;
}

} // namespace oncollide
