#include "core.hpp"

#include <algorithm>

#include <dart/common/Console.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/ShapeFrame.hpp>
#include <dart/dynamics/SoftMeshShape.hpp>

#include "geometry_of_shape.hpp"

namespace dart::collision {

using oncollide_client::Group;

namespace oncollide_client {

ShapeModel::ShapeModel(oncollide::World& of, const dynamics::Shape& shape, bool solid_heightmaps)
    : world(of),
      soft(shape.is<dynamics::SoftMeshShape>() ? static_cast<const dynamics::SoftMeshShape*>(&shape) : nullptr),
      is_plane(shape.is<dynamics::PlaneShape>())
{
    const PlacedGeometry placed = geometry_of(shape, solid_heightmaps);
    pose = placed.pose;
    if (placed.geometry) id = world.models().add(placed.geometry);
}

ShapeModel::~ShapeModel()
{
    if (id) world.models().remove(id);
}

} // namespace oncollide_client

namespace {

oncollide::Settings settings_of(const OncollideOptions& options)
{
    oncollide::Settings settings;
    settings.mode = oncollide::Mode::solid, settings.open_as_surface = true;
    settings.threads = options.threads;
    return settings;
}

} // namespace

OncollideCollisionDetector::Core::Core(const OncollideOptions& chosen) : options(chosen), world(settings_of(chosen))
{
    world.set_pair_filter([this](auto pairs, auto choices) { choose(pairs, choices); });
}

void OncollideCollisionDetector::Core::choose(std::span<const oncollide::CandidatePair> pairs,
                                              std::span<oncollide::PairChoice> choices) const
{
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const Object &a = object_of(pairs[i].a), &b = object_of(pairs[i].b);
        if ((a.model->is_plane && b.model->is_plane) || (filter_ && filter_->ignoresCollision(&a, &b)))
            choices[i] = oncollide::PairChoice::drop;
        else if (b.order < a.order)
            choices[i] = oncollide::PairChoice::refine_swapped;
    }
}

void OncollideCollisionDetector::Core::add(Object& object)
{
    objects_.push_back(&object);
    refresh(object);
}

void OncollideCollisionDetector::Core::remove(Object& object)
{
    std::erase(objects_, &object);
    if (object.body) world.bodies().remove(object.body);
    object.body = {}, object.model.reset();
}

void OncollideCollisionDetector::Core::refresh(Object& object)
{
    const dynamics::ConstShapePtr shape = object.getShape();
    object.key = shape ? ShapeModel::Key(shape->getID(), shape->getVersion()) : ShapeModel::Key();
    std::shared_ptr<ShapeModel> model;
    if (shape) {
        std::weak_ptr<ShapeModel>& known = models_[object.key];
        if (!(model = known.lock()))
            known = model = std::make_shared<ShapeModel>(world, *shape, options.solidHeightmaps);
        std::erase_if(models_, [](const auto& entry) { return entry.second.expired(); });
    }
    const bool has_model = model && model->id;
    if (object.body && has_model)
        world.bodies().set_model(object.body, model->id);
    else if (object.body)
        world.bodies().remove(std::exchange(object.body, {}));
    else if (has_model) {
        object.body = world.bodies().add({.model = model->id, .layer = 0, .mask = 0});
        by_slot_.resize(std::max(by_slot_.size(), index(object.body) + std::size_t{1}));
        by_slot_[index(object.body)] = &object;
    }
    object.model = std::move(model);
}

void OncollideCollisionDetector::Core::update(Object& object)
{
    const dynamics::ConstShapePtr shape = object.getShape();
    if ((shape ? ShapeModel::Key(shape->getID(), shape->getVersion()) : ShapeModel::Key()) != object.key)
        refresh(object);
    if (!object.body) return;
    try {
        if (const dynamics::SoftMeshShape* soft = object.model->soft) {
            const_cast<dynamics::SoftMeshShape*>(soft)->update(); // the detector has to, as DART's do
            world.models().replace(object.model->id, oncollide_client::mesh_of(*soft));
        }
        const Eigen::Isometry3d pose = object.getTransform() * object.model->pose;
        if (pose.matrix() != world.bodies().pose(object.body).matrix()) world.bodies().set_pose(object.body, pose);
    } catch (const oncollide::Error& error) {
        object.sides = 0;
        if (!std::exchange(warned_of_pose_, true))
            dterr << "[OncollideCollisionDetector] " << error.what() << "; such objects have no contacts.\n";
    }
}

void OncollideCollisionDetector::Core::select(const Group& a, const Group& b)
{
    for (Object* object : objects_) object->sides = 0;
    std::vector<Object*> all;
    const auto take = [&](const Group& group, oncollide_client::Sides side) {
        group.each_object([&](Object& object) {
            if (object.sides == 0) object.order = all.size(), all.push_back(&object);
            object.sides |= side;
        });
    };
    take(a, 1), take(b, 2);
    selected_.clear();
    for (Object* object : all) {
        update(*object);
        if (object->body && object->sides) selected_.push_back(object);
    }
    for (const Object* object : objects_) {
        const std::uint32_t layer = object->sides, mask = layer == 3 ? 3 : layer == 0 ? 0 : 3 - layer;
        const oncollide::CollisionFilter filter{layer, mask};
        if (object->body && world.bodies().filter(object->body) != filter)
            world.bodies().set_filter(object->body, filter);
    }
}

} // namespace dart::collision
