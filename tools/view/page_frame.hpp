#pragma once
#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

#include <oncollide/pipeline/pipeline.hpp>
#include <oncollide/scenes/scene.hpp>

#include "view/page_blocks.hpp"

namespace oncollide::tools {

/// One frame as a page shows it.
struct PageFrame {
    nlohmann::json header; ///< counts, and how long the columns of the block are
    PageBlock block;
};

/// Turns frames into what a page shows.
class PageFrames {
public:
    /// Keeps references to both. @param most_pairs  of a frame; more are left out, separate ones first
    PageFrames(const Scene& scene, const Pipeline& pipeline, bool separate, std::size_t most_pairs);

    /// Frame `view`, the last that the pipeline ran.
    PageFrame make(const FrameView& view);

    const Eigen::Vector3d& origin() const { return origin_; } ///< poses are relative to it
    /// Bodies that frames have poses of: those that may move.
    const std::vector<std::uint32_t>& moving() const { return moving_; }
    /// By geometry: in how many pairs its bodies were that are not separate.
    const std::vector<std::uint64_t>& touched() const { return touched_; }

    /// Bytes of a frame without pairs.
    std::size_t least_bytes() const { return 20 * moving_.size() + 512; }
    static constexpr std::size_t bytes_of_pair = 51;

private:
    /// Where a pair is, in the columns of a frame.
    struct Places {
        std::vector<float> where;            ///< x y z; not a number: unknown
        std::vector<float> nearest, apart;   ///< certified bounds on the distance; negative: not measured
        std::vector<float> curve;            ///< ends of the segments that surfaces share
        std::vector<std::uint32_t> of_curve; ///< pair of each
    };
    std::vector<PairResult> chosen(std::span<const PairResult> pairs) const;
    Places places_of(std::span<const PairResult> pairs) const;

    const Scene& scene_;
    const Pipeline& pipeline_;
    bool separate_;
    std::size_t most_pairs_;
    Eigen::Vector3d origin_;
    std::vector<std::uint32_t> moving_;
    std::vector<std::uint64_t> touched_;
};

} // namespace oncollide::tools
