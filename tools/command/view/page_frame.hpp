#pragma once
#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

#include <oncollide/runs/pipeline.hpp>
#include <oncollide/scenes/scene.hpp>

#include "view/page_blocks.hpp"
#include "view/page_deforming.hpp"

namespace oncollide::tools {

/// The data of one frame for a page.
struct PageFrame {
    nlohmann::json header; ///< counts, and the lengths of the block's columns
    PageBlock block;
};

/// Turns frames into page data.
class PageFrames {
public:
    /// Keeps references to all. @param most_pairs  pairs per frame; beyond this number pairs are left out, separate
    /// ones first, and the frame has the worst verdict of each body instead
    PageFrames(const Scene& scene, const Pipeline& pipeline, const DeformingModels& deforming, bool separate,
               std::size_t most_pairs);

    /// `view`: the frame that the pipeline ran last.
    PageFrame make(const FrameView& view);

    const Eigen::Vector3d& origin() const { return origin_; } ///< poses are relative to it
    /// Bodies whose poses are stored per frame: bodies that may move.
    const std::vector<std::uint32_t>& moving() const { return moving_; }
    /// The number of pairs that were not separate, by the geometry of their bodies.
    const std::vector<std::uint64_t>& touched() const { return touched_; }

    /// Bytes of a frame without pairs.
    std::size_t least_bytes() const { return 20 * moving_.size() + deforming_.bytes_of_frame() + scene_.size() + 512; }
    std::size_t bytes_of_pair() const;
    static const std::size_t bytes_of_rest; ///< bytes of the curves and regions of a frame, at most

private:
    /// Positions of pairs, as columns of a frame.
    struct Places {
        std::vector<float> where;            ///< x y z; NaN: unknown
        std::vector<float> nearest, apart;   ///< certified bounds on the distance; negative: not measured
        std::vector<float> curve;            ///< ends of the segments that surfaces share
        std::vector<std::uint32_t> of_curve; ///< the pair of each segment
    };
    std::vector<PairResult> chosen(std::span<const PairResult> pairs) const;
    std::vector<std::uint8_t> worst_of_bodies(std::span<const PairResult> pairs) const;
    static std::vector<const PairSweep*> sweeps_of(const FrameView& view, std::span<const PairResult> chosen);
    Places places_of(std::span<const PairResult> pairs, std::span<const PairSweep* const> sweeps) const;

    const Scene& scene_;
    const Pipeline& pipeline_;
    const DeformingModels& deforming_;
    bool separate_;
    std::size_t most_pairs_;
    Eigen::Vector3d origin_;
    std::vector<std::uint32_t> moving_;
    std::vector<std::uint64_t> touched_;
};

} // namespace oncollide::tools
