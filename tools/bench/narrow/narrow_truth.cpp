// The correct results of poses.
#include "bench/narrow/narrow_race.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "bench/bench.hpp"
#include "cli/progress.hpp"
#include "peers/fcl_pair.hpp"

namespace oncollide::tools {
namespace {

/// CGAL's results, if this build has it.
std::unique_ptr<NarrowPeer> make_exact_judge(const Mesh& a, const Mesh& b)
{
    for (const NarrowContender& contender : narrow_contenders().all)
        if (contender.name == "cgal") return contender.make(a, b);
    return nullptr;
}

class Judge {
public:
    Judge(const Mesh& a, const Mesh& b, const NarrowWorkload& workload, const std::vector<NarrowQuery>& queries)
        : workload_(workload), all_(wants(queries, NarrowQuery::all)),
          distances_(wants(queries, NarrowQuery::distance)), fcl_(a, b, FclNodes::obbrss),
          exact_(make_exact_judge(a, b)), diagonal_(a.bounds.diagonal())
    {
    }

    NarrowTruth run()
    {
        Progress progress("judging", workload_.poses.size());
        for (const NarrowPose& pose : workload_.poses) judge(pose), progress.step();
        truth_.notes.emplace_back(exact_ ? "CGAL, exact predicates"
                                         : "FCL; this build does not have CGAL, which is exact");
        if (differ_)
            truth_.notes.push_back(
                fmt::format("FCL differs from CGAL in {} of {} poses", grouped(differ_), workload_.poses.size()));
        if (expected_)
            truth_.notes.push_back(fmt::format("expected results: {} poses, {} contradicted by the judge{}",
                                               grouped(expected_), unexpected_,
                                               all_ ? fmt::format("; {} triangle pairs, {} found by the judge",
                                                                  grouped(expected_pairs_), grouped(found_pairs_))
                                                    : ""));
        if (distances_ && misplaced_ > 1e-6)
            truth_.notes.push_back(
                fmt::format("FCL's distances differ by up to {:.2g} % from the requested distances", 100 * misplaced_));
        return std::move(truth_);
    }

private:
    static bool wants(const std::vector<NarrowQuery>& queries, NarrowQuery query)
    {
        return std::find(queries.begin(), queries.end(), query) != queries.end();
    }

    void judge(const NarrowPose& pose)
    {
        const KnownPose& known = pose.known;
        std::vector<TrianglePair> pairs = pairs_by_fcl(known.b);
        bool colliding = !pairs.empty();
        if (exact_) {
            std::vector<TrianglePair> exact;
            if (all_) exact_->all_pairs(known.b, exact), std::sort(exact.begin(), exact.end());
            const bool meet = all_ ? !exact.empty() : exact_->collides(known.b);
            differ_ += all_ ? exact != pairs : meet != colliding;
            pairs = std::move(exact), colliding = meet;
        }
        if (known.colliding) ++expected_, unexpected_ += colliding != *known.colliding;
        if (known.triangle_pairs) expected_pairs_ += *known.triangle_pairs, found_pairs_ += pairs.size();
        truth_.colliding.push_back(known.colliding.value_or(colliding));
        if (all_) truth_.pairs.push_back(std::move(pairs));
        if (!distances_) return;
        truth_.distances.push_back(colliding ? 0 : fcl_.distance(known.b));
        if (pose.distance)
            misplaced_ = std::max(misplaced_, std::abs(truth_.distances.back() - *pose.distance) / diagonal_);
    }

    /// Finds at most one pair if not all are requested.
    std::vector<TrianglePair> pairs_by_fcl(const Eigen::Isometry3d& b)
    {
        std::vector<TrianglePair> pairs;
        if (all_)
            fcl_.all_pairs(b, pairs);
        else if (fcl_.collides(b))
            pairs.push_back({0, 0});
        std::sort(pairs.begin(), pairs.end());
        return pairs;
    }

    const NarrowWorkload& workload_;
    bool all_, distances_;
    FclPair fcl_;
    std::unique_ptr<NarrowPeer> exact_;
    double diagonal_;
    NarrowTruth truth_;
    std::uint64_t differ_ = 0, expected_ = 0, unexpected_ = 0, expected_pairs_ = 0, found_pairs_ = 0;
    double misplaced_ = 0; ///< largest difference from a requested distance, relative to the diagonal
};

} // namespace

NarrowTruth judge(const Mesh& a, const Mesh& b, const NarrowWorkload& workload, const std::vector<NarrowQuery>& queries)
{
    return Judge(a, b, workload, queries).run();
}

} // namespace oncollide::tools
