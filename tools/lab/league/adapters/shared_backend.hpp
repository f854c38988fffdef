// One OpenGL backend for all Worlds of a process, one after the other: a context takes milliseconds to make.
#pragma once
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <oncollide/narrowphase/gl/gpu.hpp>

namespace league {

/// Leaves the shared backend without trees when it ends.
class SharedBackend final : public oncollide::OcclusionBackend {
public:
    SharedBackend() = default;
    SharedBackend(const SharedBackend&) = delete;
    SharedBackend& operator=(const SharedBackend&) = delete;
    ~SharedBackend() override
    {
        for (const std::uint32_t tree : trees_) shared().detach(tree);
    }

    std::string name() const override { return shared().name(); }
    std::string renderer() const override { return shared().renderer(); }
    double error(double half) const override { return shared().error(half); }
    void attach(std::uint32_t tree, oncollide::Surface surface) override
    {
        shared().attach(tree, std::move(surface));
        trees_.insert(tree);
    }
    bool attached(std::uint32_t tree) const override { return trees_.contains(tree); }
    void detach(std::uint32_t tree) override { shared().detach(tree), trees_.erase(tree); }
    void submit(std::span<const oncollide::OctantRow> rows, int threads) override { shared().submit(rows, threads); }
    oncollide::BatchWork collect(std::span<oncollide::OctantResult> results) override
    {
        return shared().collect(results);
    }
    void release(std::uint32_t tree, oncollide::ListId list) override { shared().release(tree, list); }
    void read(std::span<const oncollide::ListRead> reads, std::vector<std::uint32_t>& triangles,
              std::vector<std::size_t>& ends) override
    {
        shared().read(reads, triangles, ends);
    }
    std::size_t bytes() const override { return shared().bytes(); }

private:
    /// Throws Error{no_gpu}.
    static oncollide::OcclusionBackend& shared()
    {
        static const auto backend = oncollide::make_gl_compute_backend();
        return *backend;
    }

    std::set<std::uint32_t> trees_;
};

} // namespace league
