// Bodies of a World. Ids are arrays of numbers (HeldWorld); poses are 16 numbers each.
#include "call.hpp"
#include "world.hpp"

using namespace oncollide;
using namespace oncollide::web;

/// @param poses  `count` of them
ONCOLLIDE_WEB int oc_bodies_add(HeldWorld* held, double model, const double* poses, std::size_t count, bool is_static,
                                std::uint32_t layer, std::uint32_t mask, std::uint32_t group, double user)
{
    return call([=] {
        BodySpec spec{.model = held->model(model),
                      .is_static = is_static,
                      .layer = layer,
                      .mask = mask,
                      .group = group,
                      .user = static_cast<std::uint64_t>(user)};
        std::vector<BodySpec> specs(count, spec);
        for (std::size_t i = 0; i < count; ++i) specs[i].pose = pose_at(poses, i);
        std::vector<BodyId> ids(count);
        held->world.bodies().add(specs, ids);
        double* const to = results().make(count, 1);
        for (std::size_t i = 0; i < count; ++i) to[i] = number_of(ids[i]);
    });
}
ONCOLLIDE_WEB int oc_bodies_remove(HeldWorld* held, const double* ids, std::size_t count)
{
    return call([=] { held->world.bodies().remove(held->bodies(ids, count)); });
}
ONCOLLIDE_WEB int oc_bodies_pose(const HeldWorld* held, const double* ids, std::size_t count)
{
    return call([=] {
        const std::vector<BodyId> bodies = held->bodies(ids, count); // before the results, which may lie there
        double* const to = results().make(count, 16);
        for (std::size_t i = 0; i < count; ++i)
            Eigen::Map<Eigen::Matrix4d>(to + 16 * i) = held->world.bodies().pose(bodies[i]).matrix();
    });
}
ONCOLLIDE_WEB int oc_bodies_set_pose(HeldWorld* held, const double* ids, const double* poses, std::size_t count)
{
    return call([=] {
        if (count == 1)
            held->world.bodies().set_pose(held->body(ids[0]), pose_at(poses, 0));
        else
            held->world.bodies().set_pose(held->bodies(ids, count), poses_at(poses, count));
    });
}
ONCOLLIDE_WEB int oc_bodies_set_motion(HeldWorld* held, const double* ids, const double* poses, std::size_t count,
                                       int path)
{
    return call([=] {
        held->world.bodies().set_motion(held->bodies(ids, count), poses_at(poses, count),
                                        static_cast<MotionPath>(path));
    });
}
/// Changes: 0 static, 1 dynamic, 2 sleep, 3 wake.
ONCOLLIDE_WEB int oc_bodies_change(HeldWorld* held, const double* ids, std::size_t count, int change)
{
    return call([=] {
        const std::vector<BodyId> bodies = held->bodies(ids, count);
        if (change < 2)
            held->world.bodies().set_static(bodies, change == 0);
        else if (change == 2)
            held->world.bodies().sleep(bodies);
        else
            held->world.bodies().wake(bodies);
    });
}
ONCOLLIDE_WEB int oc_bodies_set_filter(HeldWorld* held, const double* ids, std::size_t count, std::uint32_t layer,
                                       std::uint32_t mask, std::uint32_t group)
{
    return call([=] {
        held->world.bodies().set_filter(held->bodies(ids, count), {.layer = layer, .mask = mask, .group = group});
    });
}
ONCOLLIDE_WEB int oc_bodies_set_model(HeldWorld* held, const double* ids, std::size_t count, double model)
{
    return call([=] { held->world.bodies().set_model(held->bodies(ids, count), held->model(model)); });
}
ONCOLLIDE_WEB int oc_bodies_exclude(HeldWorld* held, double a, double b, bool exclude)
{
    return call([=] {
        if (exclude)
            held->world.bodies().exclude(held->body(a), held->body(b));
        else
            held->world.bodies().include(held->body(a), held->body(b));
    });
}
/// Model, static, asleep, layer, mask, group, user.
ONCOLLIDE_WEB int oc_bodies_info(const HeldWorld* held, double id)
{
    return call([=] {
        const Bodies& bodies = held->world.bodies();
        const BodyId body = held->body(id);
        const CollisionFilter filter = bodies.filter(body);
        ColumnWriter row(results(), 1, 7);
        for (const double number :
             {number_of(bodies.model(body)), double(bodies.is_static(body)), double(bodies.is_asleep(body)),
              double(filter.layer), double(filter.mask), double(filter.group), double(bodies.user(body))})
            row.next(0, number);
    });
}
ONCOLLIDE_WEB int oc_bodies_contains(const HeldWorld* held, double id)
{
    return held->world.bodies().contains(held->body(id));
}
