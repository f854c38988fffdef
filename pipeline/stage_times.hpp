#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include <oncollide/pipeline/results.hpp>

namespace oncollide {

/// The time of every frame by stage, for a picture: frame by frame up to 4,096 of them, then the sums of 2, 4, 8 ...
/// frames in a row.
class StageTimes {
public:
    /// @param stages  as many in every call; a frame that has fewer spent no time in the others
    void add(std::span<const StageStats> frame, std::size_t stages);

    std::size_t frames() const { return frames_; }
    /// Time by stage in one column of a chart, ms: the mean of the frames that fall in it.
    struct Column {
        std::vector<double> ms;
        double sum;
    };
    /// At most so many.
    std::vector<Column> columns(std::size_t most) const;

private:
    static constexpr std::size_t most_bins = 4096;
    void halve();

    std::size_t stages_ = 0, frames_ = 0, width_ = 1; ///< of a bin, in frames; the last may have fewer
    std::vector<double> ms_;                          ///< bins x stages, sums
};

} // namespace oncollide
