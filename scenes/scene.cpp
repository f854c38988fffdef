#include <oncollide/scenes/scene.hpp>

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/function_ref.hpp>
#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/base/rigid.hpp>
#include <oncollide/scenes/recording.hpp>

namespace oncollide {

namespace {

/// "body 'crane'", or "body 17" if it has no name.
std::string who_is(std::string_view name, std::size_t body)
{
    return name.empty() ? fmt::format("body {}", body) : fmt::format("body '{}'", name);
}

auto body_names(const Scene& scene)
{
    return [&](std::uint32_t i) -> std::string_view { return scene.names[i]; };
}

auto geometry_names(const SceneInfo& scene)
{
    return [&](std::uint32_t i) -> std::string_view { return scene.geometries[i].name; };
}

/// True if all bits are equal.
bool same_bits(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
{
    return std::memcmp(a.data(), b.data(), sizeof(double) * 16) == 0;
}

} // namespace

GeometryId SceneInfo::add(std::string geometry_name, GeometryData data, std::string recipe)
{
    if (const Shape* shape = std::get_if<Shape>(&data)) check_shape(geometry_name, *shape);
    const auto number = static_cast<std::uint32_t>(geometries.size());
    if (!geometry_index_.add(geometry_name, number, geometry_names(*this)))
        refuse(fmt::format("geometry '{}'", geometry_name), "the scene has another geometry of this name");
    geometries.items_.push_back(
        std::make_shared<const Geometry>(Geometry{std::move(geometry_name), std::move(data), std::move(recipe)}));
    return GeometryId{number};
}

void SceneInfo::deform(GeometryId mesh, std::shared_ptr<Deformation> deformation)
{
    const std::uint32_t number = index(mesh);
    if (number >= geometries.size())
        refuse("deform", fmt::format("there is no geometry {}; the scene has {}", number, geometries.size()));
    const std::shared_ptr<const Geometry> rest = geometries.items_[number];
    if (!std::holds_alternative<Mesh>(rest->data))
        refuse(fmt::format("geometry '{}'", rest->name), "only a mesh in memory can deform");
    if (geometries.deforms(number)) refuse(fmt::format("geometry '{}'", rest->name), "has a deformation already");
    GeometryList::Rest at_rest{rest, std::move(deformation)};
    geometries.items_[number] = GeometryList::at_time(at_rest, rest, 0);
    const auto at = std::ranges::lower_bound(geometries.deforming_, number) - geometries.deforming_.begin();
    geometries.deforming_.insert(geometries.deforming_.begin() + at, number);
    geometries.rest_.insert(geometries.rest_.begin() + at, std::move(at_rest));
}

void SceneInfo::check_body(const BodyInit& body) const
{
    const auto fail = [&](const std::string& what) { refuse(who_is(body.name, size()), what); };
    if (index(body.geometry) >= geometries.size())
        fail(fmt::format("uses geometry number {}, but the scene has {}", index(body.geometry), geometries.size()));
    if (const std::string why = why_not_rigid(body.pose); !why.empty()) fail(why);
    if (!std::holds_alternative<Still>(body.motion)) {
        if (body.is_static) fail("is static, so it cannot have a motion");
        check_motion(who_is(body.name, size()), body.motion);
    }
}

SceneBodyId Scene::add_body(BodyInit body)
{
    check_body(body);
    const auto number = static_cast<std::uint32_t>(size());
    if (!body.name.empty() && !body_index_.add(body.name, number, body_names(*this)))
        refuse(who_is(body.name, number), "the scene has another body of this name");

    names.push_back(body.name);
    geometry.values_.push_back(body.geometry);
    poses.push_back(body.pose);
    if (!std::holds_alternative<Still>(body.motion)) {
        motions.bodies_.push_back(number);
        append_large(motions.motions_, std::move(body.motion));
    }
    is_static.values_.push_back(body.is_static);
    layers.values_.push_back(body.layer);
    masks.values_.push_back(body.mask);
    groups.values_.push_back(body.group);
    ++size_;
    return SceneBodyId{number};
}

void pass_bodies(const Scene& scene, BodySink& sink)
{
    for (std::uint32_t i = 0; i < scene.size(); ++i)
        if (sink.wants(i))
            sink.take(i, {.name = std::string(scene.names[i]),
                          .geometry = scene.geometry[i],
                          .pose = scene.start_pose(i),
                          .motion = scene.motions[i],
                          .is_static = scene.is_static[i] != 0,
                          .layer = scene.layers[i],
                          .mask = scene.masks[i],
                          .group = scene.groups[i]});
}

void Scene::reserve(std::size_t bodies)
{
    poses.reserve(bodies);
    is_static.values_.reserve(bodies), reserve_large(geometry.values_, bodies);
    for (BodyColumn<std::uint32_t>* column : {&layers, &masks, &groups}) reserve_large(column->values_, bodies);
}

Eigen::Isometry3d Scene::start_pose(std::size_t body) const
{
    const std::uint32_t place = body < start_of_.size() ? start_of_[body] : 0;
    return place ? starts_[place - 1] : poses[body];
}

void Scene::set_pose(SceneBodyId body, const Eigen::Isometry3d& pose)
{
    const std::uint32_t i = index(body);
    const Eigen::Isometry3d before = poses[i];
    if (same_bits(before, pose)) return;
    if (start_of_.size() < size()) start_of_.resize(size());
    if (!start_of_[i]) {
        starts_.push_back(before);
        start_of_[i] = static_cast<std::uint32_t>(starts_.size());
    }
    poses.set(i, pose);
    note(body, true);
}

void Scene::expect_motion()
{
    if (motions.bodies().empty()) return;
    poses.reserve(size());
    start_of_.resize(size());
    starts_.reserve(starts_.size() + motions.bodies().size());
    changes.reserve(most_changes());
}

void Scene::set_position(SceneBodyId body, const Eigen::Vector3d& position)
{
    Eigen::Isometry3d pose = poses[index(body)];
    pose.translation() = position;
    set_pose(body, pose);
}

void Scene::set_geometry(SceneBodyId body, GeometryId of)
{
    geometry.values_[index(body)] = of;
    note(body);
}

void Scene::set_static(SceneBodyId body, bool now)
{
    is_static.values_[index(body)] = now;
    note(body);
}

void Scene::set_layers(SceneBodyId body, std::uint32_t layer, std::uint32_t mask)
{
    layers.values_[index(body)] = layer, masks.values_[index(body)] = mask;
    note(body);
}

void Scene::set_group(SceneBodyId body, std::uint32_t group)
{
    groups.values_[index(body)] = group;
    note(body);
}

void SceneInfo::exclude_pair(SceneBodyId a, SceneBodyId b, const NameColumn& names)
{
    for (const SceneBodyId body : {a, b}) {
        if (index(body) >= size())
            refuse("exclude", fmt::format("there is no body {}; the scene has {} bodies", index(body), size()));
    }
    if (a == b) refuse("exclude", fmt::format("{} with itself", who_is(names[index(a)], index(a))));
    excluded.push_back({std::min(index(a), index(b)), std::max(index(a), index(b))});
}

void Scene::exclude(SceneBodyId a, SceneBodyId b)
{
    exclude_pair(a, b, names);
}

std::optional<SceneBodyId> Scene::find(std::string_view body) const
{
    const std::optional<std::uint32_t> found = body_index_.find(body, body_names(*this));
    return found ? std::optional(SceneBodyId{*found}) : std::nullopt;
}

std::optional<GeometryId> SceneInfo::find_geometry(std::string_view geometry_name) const
{
    const std::optional<std::uint32_t> found = geometry_index_.find(geometry_name, geometry_names(*this));
    return found ? std::optional(GeometryId{*found}) : std::nullopt;
}

std::string Scene::label(SceneBodyId body) const
{
    const std::string_view own = names[index(body)];
    return own.empty() ? fmt::format("body {}", index(body)) : std::string(own);
}

void SceneInfo::check_bodies_of(const Recording& source) const
{
    if (source.first > size() || source.bodies > size() - source.first)
        refuse(source.file, fmt::format("holds poses of {} bodies, from body {} on; the scene has {} bodies",
                                        source.bodies, source.first, size()));
}

void Scene::record(std::shared_ptr<Recording> source)
{
    check_bodies_of(*source);
    for (std::uint32_t i = source->first; i < source->first + source->bodies; ++i)
        if (is_static[i] || !std::holds_alternative<Still>(motions[i]))
            refuse(source->file, fmt::format("moves {}, which {}", who_is(names[i], i),
                                             is_static[i] ? "is static" : "has a motion of its own"));
    recording = std::move(source);
    play_recording(0, true);
}

void Scene::play_recording(int frame, bool as_start)
{
    const std::uint32_t first = recording->first;
    recording->read(
        static_cast<std::uint64_t>(frame * pace),
        [&](std::uint32_t i, const Eigen::Isometry3d& pose) {
            if (as_start)
                poses.set(first + i, pose), note(SceneBodyId{first + i}, true);
            else
                set_pose(SceneBodyId{first + i}, pose);
        },
        [&](std::uint32_t i) { return who_is(names[first + i], first + i); });
}

namespace {

bool passes_a_key(const Motion& motion, double from, double to)
{
    const Keyed* const keyed = std::get_if<Keyed>(&motion);
    if (!keyed) return false;
    const auto next = std::ranges::upper_bound(keyed->keys, from, {}, &Keyed::Key::time);
    return next != keyed->keys.end() && next->time < to;
}

} // namespace

void Mover::move(Scene& scene, int frame)
{
    scene.geometries.deform(frame * scene.pace);
    if (scene.recording) scene.play_recording(frame, false);
    if (!ready_) scene.expect_motion();
    const bool from_start = !ready_ || frame < last_frame_;
    for (std::size_t k = 0; k < scene.motions.bodies().size(); ++k) {
        const std::uint32_t i = scene.motions.bodies()[k];
        const Eigen::Isometry3d start = scene.start_pose(i);
        const Eigen::Isometry3d before = scene.poses[i];
        Eigen::Isometry3d pose = from_start ? start : before;
        move_body(scene.motions.of_bodies()[k], start, scene.pace, from_start ? 0 : last_frame_, frame, pose);
        scene.set_pose(SceneBodyId{i}, pose);
        if (same_bits(before, pose) && passes_a_key(scene.motions.of_bodies()[k], scene.time, frame * scene.pace))
            scene.note(SceneBodyId{i}, true);
    }
    scene.time = frame * scene.pace;
    last_frame_ = frame;
    ready_ = true;
}

} // namespace oncollide
