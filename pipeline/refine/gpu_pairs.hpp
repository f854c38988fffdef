#pragma once
#include <chrono>
#include <memory>
#include <string>

#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>

namespace oncollide {

/// The CPU's part of the work with the GPU so far (ms), by stage.
struct GpuHostTimes {
    double tasks_ms = 0;     ///< reads columns of poses; on all threads
    double sort_ms = 0;      ///< divides the pairs between the CPU's memory of them and walks; on all threads
    double trees_ms = 0;     ///< finds the trees, and stages their new nodes
    double fill_ms = 0;      ///< writes the pairs; on all threads
    double submit_ms = 0;    ///< OpenGL's calls
    double meanwhile_ms = 0; ///< refines the CPU's own pairs and grows boxes, while the GPU works; on all threads
    double take_ms = 0;      ///< takes the results, and tests triangles that are not certain; on all threads
    double rest_ms = 0;      ///< refines pairs that the GPU left open, after the batches
};

/// Adds the time until its end to a stage.
class GpuStage {
public:
    explicit GpuStage(double& ms) : ms_(ms) {}
    ~GpuStage() { ms_ += std::chrono::duration<double, std::milli>(Clock::now() - from_).count(); }
    GpuStage(const GpuStage&) = delete;
    GpuStage& operator=(const GpuStage&) = delete;

private:
    using Clock = std::chrono::steady_clock;
    double& ms_;
    Clock::time_point from_ = Clock::now();
};

/// The GPU that decides pairs of meshes, while it works. Where it does not, note() gives the reason and the CPU
/// decides.
class GpuPairs {
public:
    /// Never throws for a GPU that is missing or faulty.
    explicit GpuPairs(const MeshWalkOptions& options);

    /// Null if there is no GPU, it was lost, or another thread owns it.
    MeshWalks* walks() const { return walks_ && walks_->is_owner() ? walks_.get() : nullptr; }
    /// Fewer pairs are left to the CPU.
    std::size_t worth_pairs() const { return worth_pairs_; }
    /// Ends the use of the GPU.
    void lose(const std::string& why);
    std::string note() const; ///< why the CPU decides pairs of meshes; empty: the GPU does
    std::string name() const;
    std::string renderer() const { return renderer_; }
    MeshWalkCounts counts() const { return walks_ ? walks_->counts() : last_; }
    GpuHostTimes& host() { return host_; }

private:
    std::unique_ptr<MeshWalks> walks_;
    std::size_t worth_pairs_;
    MeshWalkCounts last_;
    GpuHostTimes host_;
    std::string note_, renderer_;
};

} // namespace oncollide
