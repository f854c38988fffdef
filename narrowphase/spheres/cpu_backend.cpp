#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/spheres/listed_surfaces.hpp>

namespace oncollide {

namespace {

class CpuBackend final : public OcclusionBackend {
public:
    std::string name() const override { return fmt::format("cpu ({})", name_of(instruction_set())); }
    double error(double) const override { return 0; }

    void attach(std::uint32_t tree, Surface surface) override { surfaces_.attach(tree, std::move(surface)); }
    bool attached(std::uint32_t tree) const override { return surfaces_.attached(tree); }
    void detach(std::uint32_t tree) override { surfaces_.detach(tree); }

    /// Tests immediately: no other device could do it meanwhile.
    void submit(std::span<const OctantRow> rows, int threads) override
    {
        surfaces_.find(rows, {}, threads);
        results_.resize(rows.size());
        // Lists are stored in the order of the rows, so that they do not depend on threads.
        for (std::size_t i = 0; i < rows.size(); ++i) results_[i] = find(rows[i], i);
    }

    BatchWork collect(std::span<OctantResult> results) override
    {
        ONCOLLIDE_ASSERT(results.size() == results_.size());
        std::copy(results_.begin(), results_.end(), results.begin());
        return {};
    }

    void release(std::uint32_t tree, ListId list) override { surfaces_.release(tree, list); }
    void read(std::span<const ListRead> reads, std::vector<std::uint32_t>& triangles,
              std::vector<std::size_t>& ends) override
    {
        surfaces_.read(reads, triangles, ends);
    }
    std::size_t bytes() const override { return surfaces_.bytes(); }

private:
    OctantResult find(const OctantRow& row, std::size_t i)
    {
        const auto grey = static_cast<std::uint8_t>(surfaces_.entered(i) | surfaces_.inside(i));
        return {grey, row.keep_list ? surfaces_.keep(row.tree, i) : all_triangles};
    }

    ListedSurfaces surfaces_;
    std::vector<OctantResult> results_;
};

} // namespace

std::unique_ptr<OcclusionBackend> make_cpu_backend()
{
    return std::make_unique<CpuBackend>();
}

} // namespace oncollide
