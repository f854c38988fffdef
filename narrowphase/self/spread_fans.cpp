#include <oncollide/narrowphase/self/spread_fans.hpp>

#include <algorithm>
#include <memory>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/self/fan_kernel.hpp>

namespace oncollide {

std::vector<std::uint8_t> spread_fans(const Mesh& mesh, int threads)
{
    static SpreadFans* const kernel = ONCOLLIDE_CHOOSE(spread_fans_kernel);
    const std::size_t corners = 3 * mesh.triangles.size();
    std::vector<std::uint32_t> begin(mesh.vertices.size() + 2);
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) ++begin[v + 2];
    for (std::size_t v = 2; v < begin.size(); ++v) begin[v] += begin[v - 1];
    constexpr std::size_t spare = 16;
    const auto edges = std::make_unique_for_overwrite<std::uint32_t[]>(2 * corners + spare);
    std::uint32_t *const first = edges.get(), *const second = first + corners;
    std::fill_n(second + corners, spare, 0u);
    for (const auto& [a, b, c] : mesh.triangles) {
        const std::uint32_t i = begin[a + 1]++, j = begin[b + 1]++, k = begin[c + 1]++;
        first[i] = b, second[i] = c;
        first[j] = c, second[j] = a;
        first[k] = a, second[k] = b;
    }
    std::vector<std::uint8_t> spread(mesh.vertices.size());
    const FansOfVertices fans{mesh.vertices.empty() ? nullptr : mesh.vertices[0].data(), begin.data(), first, second};
    parallel_chunks(spread.size(), 4096, threads, [&](std::size_t from, std::size_t to, int) {
        kernel(fans, static_cast<std::uint32_t>(from), static_cast<std::uint32_t>(to), spread.data());
    });
    return spread;
}

} // namespace oncollide
