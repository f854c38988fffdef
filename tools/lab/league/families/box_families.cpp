// Many boxes, and which of them overlap.
#include "league/families/families.hpp"
#include "league/truths/truths.hpp"
#include "verify/cases/case_numbers.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// A box whose corners are exact in float.
LeagueBody box_at(const Vector3d& middle, const Vector3d& half)
{
    const auto on_grid = [](double x, double step) { return std::round(x / step) * step; };
    LeagueBody body{Shape(Box{half.unaryExpr([&](double h) { return std::max(on_grid(h, 0x1p-10), 0x1p-10); })})};
    body.pose.translation() = middle.unaryExpr([&](double x) { return on_grid(x, 0x1p-10); });
    return body;
}

LeagueFamily box_family(std::string name, std::string what, std::function<LeagueBody(CaseNumbers&, int)> box)
{
    return {std::move(name),
            "broad phases",
            LEAGUE_PAIRS,
            std::move(what),
            [box](std::uint64_t seed) {
                CaseNumbers draw(seed);
                LeagueCase asked{.question = LEAGUE_PAIRS};
                const int count = draw.number(2, 300);
                for (int k = 0; k < count; ++k) asked.bodies.push_back(box(draw, k));
                return asked;
            },
            truths::overlapping};
}

} // namespace

std::vector<LeagueFamily> box_league()
{
    return {box_family("boxes: random", "Up to 300 boxes of similar sizes.",
                       [](CaseNumbers& draw, int) {
                           return box_at(10 * draw.vector(), draw.real(0.2, 1) * Vector3d::Ones());
                       }),
            box_family("boxes: touching", "Boxes on a grid whose faces, edges and corners touch.",
                       [](CaseNumbers& draw, int) {
                           return box_at(Vector3d(draw.number(-6, 6), draw.number(-6, 6), draw.number(-6, 6)),
                                         Vector3d(0.5, 0.5, draw.number(1, 2) * 0.5));
                       }),
            box_family("boxes: huge and tiny", "Boxes of 2 mm among boxes of 200 m.",
                       [](CaseNumbers& draw, int) {
                           return box_at(100 * draw.vector(), draw.magnitude(-10, 6) * Vector3d::Ones());
                       }),
            box_family("boxes: in one place", "All boxes overlap, many are equal.",
                       [](CaseNumbers& draw, int) {
                           return box_at(0.1 * draw.number(0, 2) * draw.vector(), draw.number(1, 3) * Vector3d::Ones());
                       }),
            box_family("boxes: long", "Rods and plates that cross each other.", [](CaseNumbers& draw, int k) {
                Vector3d half = Vector3d::Constant(0.01);
                half[k % 3] = draw.real(5, 50);
                if (draw.one_in(3)) half[(k + 1) % 3] = draw.real(5, 50);
                return box_at(20 * draw.vector(), half);
            })};
}

} // namespace oncollide::tools
