#include <oncollide/narrowphase/self/self_near.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/feature_distance.hpp>
#include <oncollide/narrowphase/pairs/manifolds/key_numbers.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/feature_bits.hpp>
#include <oncollide/narrowphase/self/mesh_rings.hpp>
#include <oncollide/narrowphase/self/triangle_boxes.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// A vertex, an edge or the face of a triangle: bits of the corners that span it.
struct FeatureOfTriangle {
    std::uint32_t triangle;
    std::uint8_t corners;
};

struct NearPairOfMesh {
    FeatureBits a, b; ///< a < b
    FeatureOfTriangle of_a, of_b;
    Vector3d point_a, point_b;
    double distance;
};

/// The data that all threads read.
struct NearInMesh {
    const Mesh& mesh;
    std::span<const std::uint32_t> vertex;
    double dhat, rounding;
    /// By triangle: bits of the corners, and, times 8, of the edges that begin at them, which are its own. A vertex or
    /// an edge belongs to the first triangle that has it: if it is near a feature, so is this triangle.
    std::vector<std::uint8_t> own;

    NearInMesh(const Mesh& of, std::span<const std::uint32_t> first, double within)
        : mesh(of), vertex(first), dhat(within), own(of.triangles.size())
    {
        double largest = 0;
        std::vector<std::uint8_t> known(mesh.vertices.size());
        KeyNumbers edges;
        for (std::size_t t = 0; t < own.size(); ++t) {
            const std::array<std::uint32_t, 3> v = corners(static_cast<std::uint32_t>(t));
            for (unsigned k = 0; k < 3; ++k) {
                largest = std::max(largest, mesh.vertices[v[k]].cwiseAbs().maxCoeff());
                if (!std::exchange(known[v[k]], std::uint8_t{1})) own[t] |= 1u << k;
                const auto [low, high] = std::minmax(v[k], v[(k + 1) % 3]);
                bool is_new;
                edges.add(std::uint64_t{low} << 32 | high, is_new);
                if (is_new && low != high) own[t] |= 8u << k;
            }
        }
        rounding = 0x1p-45 * largest; // as near_rounding() of two bodies
    }
    std::array<std::uint32_t, 3> corners(std::uint32_t triangle) const
    {
        const auto& [a, b, c] = mesh.triangles[triangle];
        return {vertex[a], vertex[b], vertex[c]};
    }
    /// The vertices that span a feature. Returns their number.
    std::size_t vertices_of(FeatureOfTriangle feature, std::array<std::uint32_t, 3>& found) const
    {
        const std::array<std::uint32_t, 3> v = corners(feature.triangle);
        std::size_t count = 0;
        for (std::size_t k = 0; k < 3; ++k)
            if (feature.corners >> k & 1) found[count++] = v[k];
        return count;
    }
    FeatureBits bits_of(FeatureOfTriangle feature) const
    {
        std::array<std::uint32_t, 3> v;
        const std::size_t count = vertices_of(feature, v);
        return count == 3   ? face_feature(feature.triangle)
               : count == 2 ? edge_feature(v[0], v[1])
                            : vertex_feature(v[0]);
    }
};

bool share_one(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b)
{
    return std::ranges::any_of(a, [&](std::uint32_t v) { return std::ranges::find(b, v) != b.end(); });
}

/// The work of one thread.
class NearInPart {
public:
    explicit NearInPart(const NearInMesh& in) : in_(in), most_(in.dhat + in.rounding) {}

    /// Appends the near pairs of the own features of two triangles. Leaves out features that share a vertex.
    void try_pair(std::uint32_t s, std::uint32_t t, std::vector<NearPairOfMesh>& found)
    {
        found_ = &found;
        const std::array<std::uint32_t, 3> v = in_.corners(s), w = in_.corners(t);
        const TrianglePoints p = corners_of(in_.mesh, s), q = corners_of(in_.mesh, t);
        for (unsigned k = 0; k < 3; ++k) {
            if (in_.own[s] >> k & 1) try_corner(s, k, v[k], p[k], t, w, q);
            if (in_.own[t] >> k & 1) try_corner(t, k, w[k], q[k], s, v, p);
        }
        for (unsigned of_s = in_.own[s] >> 3; of_s; of_s &= of_s - 1)
            for (unsigned of_t = in_.own[t] >> 3; of_t; of_t &= of_t - 1) {
                const auto i = static_cast<unsigned>(std::countr_zero(of_s)), i2 = (i + 1) % 3;
                const auto k = static_cast<unsigned>(std::countr_zero(of_t)), k2 = (k + 1) % 3;
                if (v[i] == w[k] || v[i] == w[k2] || v[i2] == w[k] || v[i2] == w[k2]) continue;
                if (are_apart(std::array{p[i], p[i2]}, std::array{q[k], q[k2]})) continue;
                const auto [x, y, distance] = nearest_of_segments(p[i], p[i2], q[k], q[k2], 0.5 * in_.rounding, most_);
                if (distance > most_ * (1 + 0x1p-40)) continue;
                const auto spanned = [](unsigned first, unsigned last, double at) {
                    return static_cast<std::uint8_t>(at <= 0   ? 1 << first
                                                     : at >= 1 ? 1 << last
                                                               : 1 << first | 1 << last);
                };
                add({s, spanned(i, i2, x)}, p[i] + x * (p[i2] - p[i]), {t, spanned(k, k2, y)},
                    q[k] + y * (q[k2] - q[k]));
            }
    }

private:
    /// True if the AABBs of these points are farther apart than the search reaches.
    bool are_apart(const auto& a, const auto& b) const
    {
        for (int axis = 0; axis < 3; ++axis) {
            double low_a = a[0][axis], high_a = low_a, low_b = b[0][axis], high_b = low_b;
            for (const Vector3d& p : a) low_a = std::min(low_a, p[axis]), high_a = std::max(high_a, p[axis]);
            for (const Vector3d& p : b) low_b = std::min(low_b, p[axis]), high_b = std::max(high_b, p[axis]);
            if (std::max(low_b - high_a, low_a - high_b) > most_ * (1 + 0x1p-40)) return true;
        }
        return false;
    }
    void try_corner(std::uint32_t s, unsigned k, std::uint32_t vertex, const Vector3d& at, std::uint32_t t,
                    const std::array<std::uint32_t, 3>& corners, const TrianglePoints& points)
    {
        if (std::ranges::find(corners, vertex) != corners.end()) return;
        if (are_apart(std::array{at}, points)) return;
        const OnTriangle on = nearest_on(points, at, 0.5 * in_.rounding, most_);
        add({s, static_cast<std::uint8_t>(1u << k)}, at, {t, on.corners}, on.at);
    }
    void add(FeatureOfTriangle a, const Vector3d& at_a, FeatureOfTriangle b, const Vector3d& at_b)
    {
        const double distance = (at_a - at_b).norm();
        if (!(distance <= most_)) return;
        std::array<std::uint32_t, 3> of_a, of_b;
        const std::size_t count_a = in_.vertices_of(a, of_a), count_b = in_.vertices_of(b, of_b);
        if (share_one({of_a.data(), count_a}, {of_b.data(), count_b})) return;
        const FeatureBits bits_a = in_.bits_of(a), bits_b = in_.bits_of(b);
        if (bits_a < bits_b)
            found_->push_back({bits_a, bits_b, a, b, at_a, at_b, distance});
        else
            found_->push_back({bits_b, bits_a, b, a, at_b, at_a, distance});
    }

    const NearInMesh& in_;
    const double most_;
    std::vector<NearPairOfMesh>* found_ = nullptr;
};

/// Distance of two features, not both of them faces, at other positions of the vertices.
double distance_at(std::span<const Vector3d> positions, const Mesh& mesh, FeatureOfTriangle a, FeatureOfTriangle b)
{
    const auto points = [&](FeatureOfTriangle of, TrianglePoints& found) {
        int count = 0;
        for (std::size_t k = 0; k < 3; ++k)
            if (of.corners >> k & 1)
                found[static_cast<std::size_t>(count++)] = positions[mesh.triangles[of.triangle][k]];
        return count;
    };
    TrianglePoints p, q;
    int count_p = points(a, p), count_q = points(b, q);
    double largest = 0;
    for (int k = 0; k < 3; ++k) {
        if (k < count_p) largest = std::max(largest, p[static_cast<std::size_t>(k)].cwiseAbs().maxCoeff());
        if (k < count_q) largest = std::max(largest, q[static_cast<std::size_t>(k)].cwiseAbs().maxCoeff());
    }
    const double rounding = 0x1p-46 * largest;
    if (count_q == 3) std::swap(p, q), std::swap(count_p, count_q);
    if (count_p == 3) return (nearest_on(p, q[0], rounding).at - q[0]).norm();
    const Vector3d &p1 = p[static_cast<std::size_t>(count_p - 1)], &q1 = q[static_cast<std::size_t>(count_q - 1)];
    return nearest_of_segments(p[0], p1, q[0], q1, rounding).distance;
}

/// Sorts by features, and keeps of equal ones the nearest.
void sort_pairs_once(std::vector<NearPairOfMesh>& found)
{
    const auto order = [](const NearPairOfMesh& p) {
        return std::tuple(p.a, p.b, p.distance, p.of_a.triangle, p.of_b.triangle);
    };
    std::ranges::sort(found, {}, order);
    const auto same = [](const NearPairOfMesh& x, const NearPairOfMesh& y) { return x.a == y.a && x.b == y.b; };
    found.erase(std::unique(found.begin(), found.end(), same), found.end());
}

} // namespace

std::vector<NearFeatures> self_near(const Mesh& mesh, std::span<const std::uint32_t> vertex, double dhat,
                                    const SelfNearOptions& options, int threads)
{
    const NearInMesh in(mesh, vertex, dhat);
    const TriangleBoxes boxes(mesh, dhat + in.rounding, threads);
    std::optional<MeshRings> rings;
    if (options.rings > 1) rings.emplace(mesh, vertex);
    std::vector<std::vector<NearPairOfMesh>> found(boxes.parts());
    parallel_chunks(found.size(), 1, threads, [&](std::size_t begin, std::size_t end, int) {
        NearInPart worker(in);
        std::optional<MeshRings::Search> search;
        if (rings) search.emplace(*rings);
        const auto are_neighbours = [&](const NearPairOfMesh& pair) {
            if (!options.rest.empty() && distance_at(options.rest, mesh, pair.of_a, pair.of_b) <= options.rest_distance)
                return true;
            if (!search) return false; // features that share a vertex are left out before
            std::array<std::uint32_t, 3> of_a, of_b;
            const std::size_t count_a = in.vertices_of(pair.of_a, of_a), count_b = in.vertices_of(pair.of_b, of_b);
            return search->connects({of_a.data(), count_a}, {of_b.data(), count_b}, options.rings - 1);
        };
        for (std::size_t part = begin; part < end; ++part) {
            boxes.find(part, [&](const std::uint32_t* i, const std::uint32_t* j, std::uint64_t count) {
                for (std::uint64_t k = 0; k < count; ++k) {
                    const auto [s, t] = std::minmax({boxes.triangle_at(i[k]), boxes.triangle_at(j[k])});
                    worker.try_pair(s, t, found[part]);
                }
            });
            sort_pairs_once(found[part]);
            std::erase_if(found[part], are_neighbours);
        }
    });
    std::vector<NearPairOfMesh> all;
    for (const std::vector<NearPairOfMesh>& of_part : found) all.insert(all.end(), of_part.begin(), of_part.end());
    sort_pairs_once(all);
    std::vector<NearFeatures> features;
    features.reserve(all.size());
    for (const NearPairOfMesh& p : all)
        features.push_back(
            {p.a, p.b, std::max(p.distance - in.rounding, 0.0), p.distance + in.rounding, p.point_a, p.point_b});
    return features;
}

} // namespace oncollide
