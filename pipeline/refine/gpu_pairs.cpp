#include <oncollide/pipeline/refine/gpu_pairs.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

namespace oncollide {

GpuPairs::GpuPairs(const MeshWalkOptions& options) : worth_pairs_(std::max<std::size_t>(options.worth_pairs, 1))
{
    try {
        walks_ = options.make ? options.make() : make_mesh_walks(options);
        renderer_ = walks_->info().renderer;
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::no_gpu) throw;
        note_ = fmt::format("gl: the CPU decides all pairs: {}", error.what());
    }
}

void GpuPairs::lose(const std::string& why)
{
    if (walks_) last_ = walks_->counts();
    walks_.reset();
    note_ = fmt::format("gl: the CPU took over when the GPU was lost: {}", why);
}

std::string GpuPairs::note() const
{
    if (!note_.empty() || !walks_) return note_;
    const std::uint64_t left_out = walks_->counts().trees_without_room;
    return left_out == 0 ? ""
                         : fmt::format("gl: {} meshes have no room on the GPU; the CPU decides their pairs", left_out);
}

std::string GpuPairs::name() const
{
    return walks_ ? fmt::format("gl ({})", renderer_) : "gl (on the CPU)";
}

} // namespace oncollide
