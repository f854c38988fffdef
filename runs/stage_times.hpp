#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include <oncollide/pipeline/results.hpp>

namespace oncollide {

/// The time of every frame by stage, for a chart: single frames up to 4,096, then sums of 2, 4, 8 ... consecutive
/// frames.
class StageTimes {
public:
    /// @param stages  the same in every call; missing stages of a frame count as 0 ms
    void add(std::span<const StageStats> frame, std::size_t stages);

    std::size_t frames() const { return frames_; }
    /// One column of a chart: mean time by stage of its frames, ms.
    struct Column {
        std::vector<double> ms;
        double sum;
    };
    /// Returns at most `most` columns.
    std::vector<Column> columns(std::size_t most) const;

private:
    static constexpr std::size_t most_bins = 4096;
    void halve();

    std::size_t stages_ = 0, frames_ = 0, width_ = 1; ///< width_: frames per bin; the last bin may have fewer
    std::vector<double> ms_;                          ///< bins x stages, sums
};

} // namespace oncollide
