#pragma once
#include <memory>
#include <string>

#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>

namespace oncollide {

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

private:
    std::unique_ptr<MeshWalks> walks_;
    std::size_t worth_pairs_;
    MeshWalkCounts last_;
    std::string note_, renderer_;
};

} // namespace oncollide
