// A fan is projected along the sum of its normals. Let all of its triangles be counter-clockwise around the vertex, and
// let every edge from the vertex end one triangle and begin another one. Then the same number of triangles covers every
// direction between edges, and the triangles that end in one direction have the edges of the triangles that begin
// there. If this number is one, the fan is spread out.
#include <oncollide/narrowphase/self/spread_fans.hpp>

#include <bit>
#include <cmath>
#include <span>

#include <Eigen/Geometry>

namespace oncollide {

namespace {

using Eigen::Vector3d;

constexpr std::uint32_t most_in_fan = 32;
/// Products of magnitudes times this bound the rounding errors here: differences of coordinates and up to three more
/// factors are each rounded by 2^-53, and sums of at most 18 terms by as much each. The addend covers underflow.
constexpr double rounding = 0x1p-47, least = 0x1p-900;

double sum(const Vector3d& v)
{
    return std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
}

/// The triangles at each vertex.
struct Incidence {
    std::vector<std::uint32_t> begin; ///< by vertex, and one more
    std::vector<std::uint32_t> triangles;

    explicit Incidence(const Mesh& mesh) : begin(mesh.vertices.size() + 2), triangles(3 * mesh.triangles.size())
    {
        for (const Triangle& t : mesh.triangles)
            for (const std::uint32_t v : t) ++begin[v + 2];
        for (std::size_t v = 2; v < begin.size(); ++v) begin[v] += begin[v - 1];
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            for (const std::uint32_t v : mesh.triangles[t]) triangles[begin[v + 1]++] = t;
    }
};

/// The triangles at one vertex. Each goes from a first to a second edge, named by its other vertex.
class Fan {
public:
    bool is_spread(const Mesh& mesh, std::span<const std::uint32_t> triangles, std::uint32_t vertex)
    {
        count_ = static_cast<std::uint32_t>(triangles.size());
        if (count_ < 3 || count_ > most_in_fan) return false;
        for (std::uint32_t i = 0; i < count_; ++i) {
            const Triangle& t = mesh.triangles[triangles[i]];
            const unsigned k = t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
            first_[i] = t[(k + 1) % 3], second_[i] = t[(k + 2) % 3];
        }
        // Angles are below 180 degrees, so four of them cannot go round twice.
        return is_closed() && is_counter_clockwise(mesh, mesh.vertices[vertex]) && (count_ <= 4 || goes_round_once());
    }

private:
    /// True if every second edge is the first edge of exactly one triangle, and the reverse.
    bool is_closed()
    {
        std::uint32_t all = 0;
        for (std::uint32_t i = 0; i < count_; ++i) {
            std::uint32_t next = 0;
            for (std::uint32_t j = 0; j < count_; ++j) next |= std::uint32_t(first_[j] == second_[i]) << j;
            if (next == 0 || (next & (next - 1))) return false;
            next_[i] = static_cast<std::uint32_t>(std::countr_zero(next));
            all |= next;
        }
        return std::popcount(all) == int(count_);
    }
    bool is_counter_clockwise(const Mesh& mesh, const Vector3d& at)
    {
        for (std::uint32_t i = 0; i < count_; ++i) edges_[i] = mesh.vertices[first_[i]] - at;
        double x = 0, y = 0, z = 0; // a vector in memory would stall the processor
        for (std::uint32_t i = 0; i < count_; ++i) {
            const Vector3d &u = edges_[i], &v = edges_[next_[i]];
            normals_[0][i] = u[1] * v[2] - u[2] * v[1], x += normals_[0][i];
            normals_[1][i] = u[2] * v[0] - u[0] * v[2], y += normals_[1][i];
            normals_[2][i] = u[0] * v[1] - u[1] * v[0], z += normals_[2][i];
        }
        along_ = {x, y, z};
        const double length = sum(along_);
        for (std::uint32_t i = 0; i < count_; ++i) lengths_[i] = sum(edges_[i]);
        for (std::uint32_t i = 0; i < count_; ++i)
            if (!(normals_[0][i] * x + normals_[1][i] * y + normals_[2][i] * z >
                  rounding * lengths_[i] * lengths_[next_[i]] * length + least))
                return false;
        return true;
    }
    /// True if the direction of the first edge of all is certainly outside of all triangles that do not have this edge.
    bool goes_round_once() const
    {
        const Vector3d left = along_.cross(edges_[0]);
        const double bound = rounding * sum(along_) * lengths_[0];
        const auto side = [&](std::uint32_t i) {
            const double height = left.dot(edges_[i]), error = bound * lengths_[i] + least;
            return (height > error) - (height < -error);
        };
        for (std::uint32_t i = 1; i < count_; ++i)
            if (next_[i] != 0 && side(i) <= 0 && side(next_[i]) >= 0) return false;
        return true;
    }

    std::uint32_t count_ = 0, first_[most_in_fan], second_[most_in_fan];
    std::uint32_t next_[most_in_fan]; ///< the triangle whose first edge is the second edge of this one
    Vector3d edges_[most_in_fan];     ///< the first edges
    double lengths_[most_in_fan];     ///< upper bounds, for errors
    double normals_[3][most_in_fan];
    Vector3d along_;
};

} // namespace

std::vector<std::uint8_t> spread_fans(const Mesh& mesh)
{
    const Incidence at(mesh);
    std::vector<std::uint8_t> spread(mesh.vertices.size());
    Fan fan;
    for (std::uint32_t v = 0; v < spread.size(); ++v)
        spread[v] = fan.is_spread(mesh, std::span(at.triangles).subspan(at.begin[v], at.begin[v + 1] - at.begin[v]), v);
    return spread;
}

} // namespace oncollide
