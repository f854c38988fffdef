#include "verify/trials/triangle_trial.hpp"

#include <fmt/format.h>

#include <oncollide/base/threads/parallel.hpp>

#include "truth/exact_oracle.hpp"

namespace oncollide::tools {
namespace {

void try_two(const oncollide::TwoTriangles& pair, TrianglesMeet fcl, Tally& tally)
{
    const auto& [a, b] = pair;
    const TriangleContact truth = oracle::contact(a, b);
    const bool meet = truth != TriangleContact::separate;
    ++tally.cases, tally.results += 3;
    const auto judge = [&](bool said, const char* how) {
        if (said != meet) tally.fault(said ? &Tally::wrong : &Tally::missed, how + shown(pair));
    };
    judge(triangles_meet(a, b), "triangles_meet(a, b):");
    const TriangleContact contact = triangle_contact(a, b), swapped = triangle_contact(b, a);
    judge(contact != TriangleContact::separate, "triangle_contact(a, b):");
    judge(swapped != TriangleContact::separate, "triangle_contact(b, a):");
    if (contact != truth && contact != TriangleContact::separate && meet)
        tally.fault(&Tally::wrong, "kind of contact:" + shown(pair));
    if (swapped != contact) tally.fault(&Tally::changed, "swapped:" + shown(pair));
    if (!fcl) return;
    const bool theirs = fcl(a, b);
    tally.fcl_missed += meet && !theirs, tally.fcl_false += theirs && !meet;
}

} // namespace

Tally try_triangles(const TriangleFamily& family, std::uint64_t count, bool rotated, int threads, TrianglesMeet fcl)
{
    constexpr std::uint64_t batch = 10'000, grain = 250;
    GridPoints random(rotated ? 2 : 1), turns(3);
    std::vector<oncollide::TwoTriangles> pairs;
    std::vector<Tally> tallies;
    Tally sum{.family = family.name + (rotated ? ", turned" : "")};
    for (std::uint64_t first = 0; first < count; first += batch) {
        pairs.clear();
        while (pairs.size() < std::min(batch, count - first)) {
            const Eigen::Matrix3d turn = rotated ? turns.rotation() : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
            pairs.push_back(moved(family.make(random), 0x1p-20 * turn, Eigen::Vector3d::Zero()));
        }
        tallies.assign((pairs.size() + grain - 1) / grain, {});
        parallel_chunks(pairs.size(), grain, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) try_two(pairs[i], fcl, tallies[i / grain]);
        });
        for (const Tally& tally : tallies) sum += tally;
    }
    return sum;
}

} // namespace oncollide::tools
