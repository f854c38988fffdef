#include <oncollide/runs/stage_times.hpp>

#include <algorithm>

namespace oncollide {

void StageTimes::add(std::span<const StageStats> frame, std::size_t stages)
{
    stages_ = stages;
    if (frames_ == most_bins * width_) halve();
    if (frames_ % width_ == 0) ms_.resize(ms_.size() + stages_);
    double* const bin = ms_.data() + ms_.size() - stages_;
    for (std::size_t k = 0; k < std::min(stages_, frame.size()); ++k) bin[k] += frame[k].cpu_ms;
    ++frames_;
}

void StageTimes::halve()
{
    for (std::size_t bin = 0; bin < most_bins / 2; ++bin)
        for (std::size_t k = 0; k < stages_; ++k)
            ms_[bin * stages_ + k] = ms_[2 * bin * stages_ + k] + ms_[(2 * bin + 1) * stages_ + k];
    ms_.resize(most_bins / 2 * stages_);
    width_ *= 2;
}

std::vector<StageTimes::Column> StageTimes::columns(std::size_t most) const
{
    const std::size_t bins = stages_ ? ms_.size() / stages_ : 0, count = std::min(bins, most);
    std::vector<Column> columns;
    for (std::size_t c = 0; c < count; ++c) {
        const std::size_t begin = c * bins / count, end = (c + 1) * bins / count;
        const double frames = double(std::min(end * width_, frames_) - begin * width_);
        Column column{std::vector<double>(stages_), 0};
        for (std::size_t bin = begin; bin < end; ++bin)
            for (std::size_t k = 0; k < stages_; ++k) column.ms[k] += ms_[bin * stages_ + k] / frames;
        for (double ms : column.ms) column.sum += ms;
        columns.push_back(std::move(column));
    }
    return columns;
}

} // namespace oncollide
