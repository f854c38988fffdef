#include "self/self_places.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include <oncollide/base/text/plain_number.hpp>

namespace oncollide::tools {
namespace {

/// Joins the vertices of triangles that meet.
class ConnectedVertices {
public:
    ConnectedVertices(const Mesh& mesh, const std::vector<TrianglesThatMeet>& pairs) : above_(mesh.vertices.size())
    {
        std::iota(above_.begin(), above_.end(), 0u);
        std::vector<std::uint32_t> used;
        for (const TrianglesThatMeet& pair : pairs)
            for (const std::uint32_t triangle : {pair.a, pair.b})
                for (const std::uint32_t v : mesh.triangles[triangle])
                    join(v, mesh.triangles[pair.a][0]), used.push_back(v);
        const auto position = [&](std::uint32_t v) {
            const Eigen::Vector3d& p = mesh.vertices[v];
            return std::array{p.x(), p.y(), p.z()};
        };
        std::ranges::sort(used, {}, position);
        for (std::size_t k = 1; k < used.size(); ++k)
            if (position(used[k - 1]) == position(used[k])) join(used[k - 1], used[k]);
    }
    std::uint32_t root(std::uint32_t v)
    {
        while (above_[v] != v) v = above_[v] = above_[above_[v]];
        return v;
    }

private:
    void join(std::uint32_t v, std::uint32_t w) { above_[root(v)] = root(w); }
    std::vector<std::uint32_t> above_; ///< a forest
};

double rounded(double value, double step)
{
    return std::round(value / step) * step + 0.0; // no -0
}

} // namespace

CommonSegment segment_of(const Mesh& mesh, TrianglesThatMeet pair)
{
    return common_segment(corners_of(mesh, pair.a), corners_of(mesh, pair.b));
}

std::vector<SelfPlace> places_of(const Mesh& mesh, const std::vector<TrianglesThatMeet>& pairs)
{
    ConnectedVertices vertices(mesh, pairs);
    std::map<std::uint32_t, SelfPlace> by_root;
    for (const TrianglesThatMeet& pair : pairs) {
        SelfPlace& place = by_root[vertices.root(mesh.triangles[pair.a][0])];
        place.pairs.push_back(pair);
        for (const Eigen::Vector3d& end : segment_of(mesh, pair).ends) place.box.add(end);
    }
    std::vector<SelfPlace> places;
    for (auto& [vertex, place] : by_root) places.push_back(std::move(place));
    std::ranges::sort(places, [](const SelfPlace& a, const SelfPlace& b) {
        return a.pairs.size() != b.pairs.size() ? a.pairs.size() > b.pairs.size() : a.pairs[0] < b.pairs[0];
    });
    return places;
}

std::string place_text(const SelfPlace& place, const Aabb& bounds, std::string_view unit)
{
    const double step = std::pow(10, std::floor(std::log10(std::max(bounds.diagonal(), 1e-300)) - 5));
    const auto place_in = [&](double x) { return plain_number(rounded(x, step), 6); };
    const auto length = [&](double x) { return plain_measure(rounded(x, 1e-6 * step), 3); };
    const Eigen::Vector3d at = place.box.centre(), size = place.box.max - place.box.min;
    return fmt::format("{} {} around ({}, {}, {}), in a box of {} x {} x {} {}, such as triangles {} and {}",
                       place.pairs.size(), place.pairs.size() == 1 ? "pair" : "pairs", place_in(at.x()),
                       place_in(at.y()), place_in(at.z()), length(size.x()), length(size.y()), length(size.z()), unit,
                       place.pairs[0].a, place.pairs[0].b);
}

} // namespace oncollide::tools
