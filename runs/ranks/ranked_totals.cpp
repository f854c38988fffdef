// Results and statistics of all ranks.
#include <oncollide/runs/ranks/ranked_run.hpp>

namespace oncollide {

std::uint64_t RankedRun::hash()
{
    std::uint64_t hash = ranks_.rank() + 1 == ranks_.size() ? hash_ : 0;
    ranks_.sum({&hash, 1});
    return hash;
}

std::array<std::uint64_t, 4> RankedRun::verdicts()
{
    auto all = verdicts_;
    ranks_.sum(all);
    return all;
}

std::array<std::uint64_t, 5> RankedRun::kinds()
{
    auto all = kinds_;
    ranks_.sum(all);
    return all;
}

std::vector<RankStatistics> RankedRun::statistics(std::uint64_t peak_memory)
{
    statistics_.peak_memory = peak_memory;
    std::vector<Bytes> out(out_.size()), in;
    put(out[0], statistics_);
    ranks_.exchange(out, in);
    std::vector<RankStatistics> all;
    for (const Bytes& bytes : in)
        if (!bytes.empty()) all.push_back(ByteReader(bytes).get<RankStatistics>());
    return all;
}

std::vector<std::vector<RankPhase>> RankedRun::phases()
{
    std::vector<Bytes> out(out_.size()), in;
    put_list(out[0], phases_);
    ranks_.exchange(out, in);
    std::vector<std::vector<RankPhase>> all;
    for (const Bytes& bytes : in)
        if (!bytes.empty()) all.push_back(ByteReader(bytes).get_list<std::vector<RankPhase>>());
    return all;
}

std::vector<StageStats> RankedRun::totals()
{
    std::vector<StageStats> all = world_.world().inspect().totals;
    for (StageStats& s : all) {
        std::array<std::uint64_t, 4> counts{s.in, s.out, s.culled, s.undecided};
        std::array<double, 4> times{s.cpu_ms, s.gpu_ms, s.wait_ms, s.skipped ? 0.0 : 1.0};
        ranks_.sum(counts), ranks_.most(times);
        s.in = counts[0], s.out = counts[1], s.culled = counts[2], s.undecided = counts[3];
        s.cpu_ms = times[0], s.gpu_ms = times[1], s.wait_ms = times[2], s.skipped = times[3] == 0;
    }
    return all;
}

} // namespace oncollide
