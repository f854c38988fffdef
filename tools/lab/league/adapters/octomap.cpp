// OctoMap's rays through the cells of a map.
#include <stdexcept>

#include <octomap/octomap.h>

#include "common.hpp"

namespace {

octomap::point3d point_of(const league::Vector& p)
{
    return {float(p[0]), float(p[1]), float(p[2])};
}

struct Ray final : league::Query {
    octomap::OcTree tree;

    explicit Ray(const league_case& asked) : tree(asked.a.size[0])
    {
        for (std::size_t i = 0; i < asked.a.vertex_count; ++i) {
            const double* const at = asked.a.vertices + 3 * i;
            const octomap::point3d centre = point_of({at[0], at[1], at[2]});
            octomap::OcTreeKey key;
            if (!tree.coordToKeyChecked(centre, key)) throw std::out_of_range("beyond the octree");
            if ((tree.keyToCoord(key) - centre).norm() > 1e-4 * asked.a.size[0])
                throw std::domain_error("off the grid");
            tree.updateNode(key, true, true);
        }
        tree.updateInnerOccupancy();
    }

    int answer(const league_case& asked, league_answer& answer) override
    {
        const auto relative = [&](int k) { return asked.from[k] - asked.a.position[k]; };
        const league::Vector motion =
            league::to_body_direction(asked.a, {asked.motion[0], asked.motion[1], asked.motion[2]});
        const double length = league::length_of(motion);
        octomap::point3d centre, entry;
        const octomap::point3d start = point_of(
                                   league::to_body_direction(asked.a, {relative(0), relative(1), relative(2)})),
                               way = point_of({motion[0] / length, motion[1] / length, motion[2] / length});
        answer.meet = tree.castRay(start, way, centre, true, length);
        if (!answer.meet) return LEAGUE_ANSWERED;
        octomap::OcTreeKey first, hit;
        if (tree.coordToKeyChecked(start, first) && tree.coordToKeyChecked(centre, hit) && first == hit)
            return LEAGUE_ANSWERED; // at time 0
        if (!tree.getRayIntersection(start, way, centre, entry)) return LEAGUE_FAILED;
        answer.time = double((entry - start).norm()) / length;
        return LEAGUE_ANSWERED;
    }
};

int supports(int question, int kind, int)
{
    return question == LEAGUE_RAY && kind == LEAGUE_CELLS;
}

constexpr league_library libraries[] = {league::library_of<league::make<Ray>>({
    .name = "octomap",
    .settings =
        "OcTree::castRay() through unknown cells, getRayIntersection(); single precision; its cells are half-open",
    .source = "octomap/OccupancyOcTreeBase.h",
    .supports = supports,
    .bits = 32,
    .precision = 1e-5,
})};

} // namespace

const league_library* league_open(int number)
{
    return league::library_at(libraries, number);
}
