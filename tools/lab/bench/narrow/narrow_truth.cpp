// The correct results of poses.
#include "bench/narrow/narrow_race.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/narrowphase/exact/relative_pose.hpp>

#include "cli/progress.hpp"
#include "common/text.hpp"
#include "truth/truth.hpp"

namespace oncollide::tools {
namespace {

class Judge {
public:
    Judge(const Mesh& a, const Mesh& b, const NarrowWorkload& workload, const std::vector<NarrowQuery>& queries)
        : workload_(workload), all_(wants(queries, NarrowQuery::all)),
          distances_(wants(queries, NarrowQuery::distance)), a_(a, false), b_(b, false), diagonal_(a.bounds.diagonal())
    {
    }

    NarrowTruth run()
    {
        Progress progress("judging", workload_.poses.size());
        for (const NarrowPose& pose : workload_.poses) judge(pose), progress.step();
        truth_.notes.emplace_back("linear programming in integers; distances in long double");
        if (expected_)
            truth_.notes.push_back(fmt::format("expected results: {} poses, {} contradicted by the judge{}",
                                               grouped(expected_), unexpected_,
                                               all_ ? fmt::format("; {} triangle pairs, {} found by the judge",
                                                                  grouped(expected_pairs_), grouped(found_pairs_))
                                                    : ""));
        if (distances_ && misplaced_ > 1e-6)
            truth_.notes.push_back(
                fmt::format("distances differ by up to {:.2g} % from the requested distances", 100 * misplaced_));
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
        const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
        const BoxedTriangles moved(b_.halved(), RelativePose(here, known.b));
        std::vector<TrianglePair> pairs;
        if (all_)
            for_meeting_triangles(a_.at_home(), moved, [&](std::uint32_t i, std::uint32_t j) {
                pairs.push_back({i, j});
            });
        std::sort(pairs.begin(), pairs.end());
        const bool colliding =
            all_ ? !pairs.empty()
                 : contact_of(a_.at_home(), moved, TriangleContact::touching) != TriangleContact::separate;
        if (known.colliding) ++expected_, unexpected_ += colliding != *known.colliding;
        if (known.triangle_pairs) expected_pairs_ += *known.triangle_pairs, found_pairs_ += pairs.size();
        truth_.colliding.push_back(known.colliding.value_or(colliding));
        if (all_) truth_.pairs.push_back(std::move(pairs));
        if (!distances_) return;
        truth_.distances.push_back(colliding ? 0 : surface_distance(a_.halved(), here, b_.halved(), known.b).high);
        if (pose.distance)
            misplaced_ = std::max(misplaced_, std::abs(truth_.distances.back() - *pose.distance) / diagonal_);
    }

    const NarrowWorkload& workload_;
    bool all_, distances_;
    TruthModel a_, b_;
    double diagonal_;
    NarrowTruth truth_;
    std::uint64_t expected_ = 0, unexpected_ = 0, expected_pairs_ = 0, found_pairs_ = 0;
    double misplaced_ = 0; ///< largest difference from a requested distance, relative to the diagonal
};

} // namespace

NarrowTruth judge(const Mesh& a, const Mesh& b, const NarrowWorkload& workload, const std::vector<NarrowQuery>& queries)
{
    return Judge(a, b, workload, queries).run();
}

} // namespace oncollide::tools
