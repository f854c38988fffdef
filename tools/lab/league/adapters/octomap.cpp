// OctoMap's rays through the cells of a map.
#include <stdexcept>

#include <Eigen/Geometry>
#include <octomap/octomap.h>

#include "common.hpp"

namespace {

using Eigen::Vector3d;

octomap::point3d point_of(const Vector3d& p)
{
    return {float(p.x()), float(p.y()), float(p.z())};
}

Eigen::Isometry3d pose_of(const league_body& body)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(body.rotation);
    pose.translation() = Vector3d(body.position);
    return pose;
}

struct Prepared {
    octomap::OcTree tree;
    Eigen::Isometry3d into; ///< the map's frame

    explicit Prepared(const league_case& asked) : tree(asked.a.size[0]), into(pose_of(asked.a).inverse())
    {
        for (std::size_t i = 0; i < asked.a.vertex_count; ++i) {
            const Vector3d centre(asked.a.vertices + 3 * i);
            octomap::OcTreeKey key;
            if (!tree.coordToKeyChecked(point_of(centre), key)) throw std::out_of_range("beyond the octree");
            if ((tree.keyToCoord(key) - point_of(centre)).norm() > 1e-4 * asked.a.size[0])
                throw std::domain_error("off the grid");
            tree.updateNode(key, true, true);
        }
        tree.updateInnerOccupancy();
    }

    int answer(const league_case& asked, league_answer& answer) const
    {
        const Vector3d from = into * Vector3d(asked.from), motion = into.linear() * Vector3d(asked.motion);
        const double length = motion.norm();
        octomap::point3d centre, entry;
        const octomap::point3d start = point_of(from), way = point_of(motion / length);
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

void* prepare(const league_case* asked)
{
    return league::prepared_or_null<Prepared>(*asked);
}

int answer(void* prepared, const league_case* asked, league_answer* answer)
{
    return league::without_exceptions([&] { return static_cast<const Prepared*>(prepared)->answer(*asked, *answer); });
}

void release(void* prepared)
{
    delete static_cast<Prepared*>(prepared);
}

constexpr league_library library{
    .version = LEAGUE_VERSION,
    .bits = 32,
    .name = "octomap",
    .settings =
        "OcTree::castRay() through unknown cells, getRayIntersection(); single precision; its cells are half-open",
    .source = "octomap/OccupancyOcTreeBase.h",
    .precision = 1e-5,
    .conservative = 0,
    .supports = supports,
    .prepare = prepare,
    .answer = answer,
    .release = release,
};

} // namespace

const league_library* league_open(int number)
{
    return number == 0 ? &library : nullptr;
}
