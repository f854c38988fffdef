#include <oncollide/dart/detector.hpp>

#include <dart/common/Console.hpp>

#include "core.hpp"

namespace dart::collision {

using oncollide_client::Group;
using oncollide_client::Object;

OncollideCollisionDetector::Registrar<OncollideCollisionDetector> OncollideCollisionDetector::registrar_{
    getStaticType(), [] { return std::shared_ptr<CollisionDetector>(create()); }};

std::shared_ptr<OncollideCollisionDetector> OncollideCollisionDetector::create(const OncollideOptions& options)
{
    return std::shared_ptr<OncollideCollisionDetector>(new OncollideCollisionDetector(options));
}

OncollideCollisionDetector::OncollideCollisionDetector(const OncollideOptions& options)
    : core_(std::make_unique<Core>(options))
{
    mCollisionObjectManager = std::make_unique<ManagerForSharableCollisionObjects>(this);
}

OncollideCollisionDetector::~OncollideCollisionDetector() = default;

std::shared_ptr<CollisionDetector> OncollideCollisionDetector::cloneWithoutCollisionObjects() const
{
    return create(core_->options);
}

const std::string& OncollideCollisionDetector::getType() const
{
    return getStaticType();
}

const std::string& OncollideCollisionDetector::getStaticType()
{
    static const std::string type = "oncollide";
    return type;
}

std::unique_ptr<CollisionGroup> OncollideCollisionDetector::createCollisionGroup()
{
    return std::make_unique<Group>(shared_from_this());
}

const OncollideOptions& OncollideCollisionDetector::getOptions() const
{
    return core_->options;
}

std::unique_ptr<CollisionObject>
OncollideCollisionDetector::createCollisionObject(const dynamics::ShapeFrame* shapeFrame)
{
    auto object = std::make_unique<Object>(this, shapeFrame);
    core_->add(*object);
    return object;
}

void OncollideCollisionDetector::refreshCollisionObject(CollisionObject* object)
{
    core_->refresh(static_cast<Object&>(*object));
}

void OncollideCollisionDetector::notifyCollisionObjectDestroying(CollisionObject* object)
{
    core_->remove(static_cast<Object&>(*object));
}

/// False, with a message, for a group of another detector.
bool OncollideCollisionDetector::select(CollisionGroup* group1, CollisionGroup* group2)
{
    for (CollisionGroup* group : {group1, group2})
        if (group->getCollisionDetector().get() != this) {
            dterr << "[OncollideCollisionDetector] A group belongs to another detector: create it with this one.\n";
            return false;
        }
    core_->select(static_cast<Group&>(*group1), static_cast<Group&>(*group2));
    return true;
}

bool OncollideCollisionDetector::collide(CollisionGroup* group, const CollisionOption& option, CollisionResult* result)
{
    return collide(group, group, option, result);
}

bool OncollideCollisionDetector::collide(CollisionGroup* group1, CollisionGroup* group2, const CollisionOption& option,
                                         CollisionResult* result)
{
    if (result) result->clear();
    return option.maxNumContacts > 0 && select(group1, group2) && core_->collide(option, result);
}

double OncollideCollisionDetector::distance(CollisionGroup* group, const DistanceOption& option, DistanceResult* result)
{
    return distance(group, group, option, result);
}

double OncollideCollisionDetector::distance(CollisionGroup* group1, CollisionGroup* group2,
                                            const DistanceOption& option, DistanceResult* result)
{
    if (result) result->clear();
    return select(group1, group2) ? core_->distance(option, result) : 0;
}

bool OncollideCollisionDetector::raycast(CollisionGroup* group, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                         const RaycastOption& option, RaycastResult* result)
{
    if (result) result->clear();
    return select(group, group) && core_->raycast(from, to, option, result);
}

} // namespace dart::collision
