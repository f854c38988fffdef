#include "verify/trials/hard_trials.hpp"

#include <fmt/format.h>

#include "truth/exact_oracle.hpp"
#include "verify/trials/seeds.hpp"

namespace oncollide::tools {
namespace {

void try_two(const TwoTriangles& pair, Tally& tally)
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
}

} // namespace

Tally try_triangles(const TriangleFamily& family, std::uint64_t count, bool rotated, int threads)
{
    return try_many(
        family.name + (rotated ? ", turned" : ""), count, threads,
        [&](std::uint64_t number, Tally& tally) {
            GridPoints random(2 * number + rotated);
            const Eigen::Matrix3d turn = rotated ? random.rotation() : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
            try_two(moved(family.make(random), 0x1p-20 * turn, Eigen::Vector3d::Zero()), tally);
        },
        256);
}

} // namespace oncollide::tools
