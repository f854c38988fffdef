#pragma once
#include <memory>
#include <string>

#include <dart/collision/CollisionDetector.hpp>

#include <oncollide/pipeline/results.hpp>

namespace dart::collision {

/// How OncollideCollisionDetector finds contacts.
struct OncollideOptions {
    oncollide::ManifoldOptions manifold{}; ///< limits of the contacts of a pair
    int threads = 1;                       ///< 0: all. The contacts do not depend on it
    bool solidHeightmaps = false;          ///< height maps are solid down to z = 0, or to their least height if that is
                                           ///< lower; false: surfaces
};

/// oncollide as a collision detector of DART; its key in the factory is "oncollide". Shapes of one detector share one
/// World. Shapes that it does not know have no contacts, and a warning names them. See docs/dart.md.
class OncollideCollisionDetector : public CollisionDetector {
public:
    static std::shared_ptr<OncollideCollisionDetector> create(const OncollideOptions& options = {});
    ~OncollideCollisionDetector() override;

    std::shared_ptr<CollisionDetector> cloneWithoutCollisionObjects() const override;
    const std::string& getType() const override;
    static const std::string& getStaticType();
    using CollisionDetector::createCollisionGroup;
    std::unique_ptr<CollisionGroup> createCollisionGroup() override;
    const OncollideOptions& getOptions() const;

    /// Contacts of a pair are the points of its manifold (docs/contacts.md), each halfway between the two surfaces. If
    /// there are more than option.maxNumContacts, every pair keeps its deepest ones in turn, and a warning says so.
    bool collide(CollisionGroup* group, const CollisionOption& option = CollisionOption(false, 1u, nullptr),
                 CollisionResult* result = nullptr) override;
    bool collide(CollisionGroup* group1, CollisionGroup* group2,
                 const CollisionOption& option = CollisionOption(false, 1u, nullptr),
                 CollisionResult* result = nullptr) override;
    /// The least distance of all pairs. If option.distanceLowerBound is negative, bodies that penetrate have a negative
    /// one, their depth.
    double distance(CollisionGroup* group, const DistanceOption& option = DistanceOption(false, 0.0, nullptr),
                    DistanceResult* result = nullptr) override;
    double distance(CollisionGroup* group1, CollisionGroup* group2,
                    const DistanceOption& option = DistanceOption(false, 0.0, nullptr),
                    DistanceResult* result = nullptr) override;
    /// Hits are sorted by distance.
    bool raycast(CollisionGroup* group, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                 const RaycastOption& option = RaycastOption(), RaycastResult* result = nullptr) override;

protected:
    explicit OncollideCollisionDetector(const OncollideOptions& options);
    std::unique_ptr<CollisionObject> createCollisionObject(const dynamics::ShapeFrame* shapeFrame) override;
    void refreshCollisionObject(CollisionObject* object) override;
    void notifyCollisionObjectDestroying(CollisionObject* object) override;

private:
    bool select(CollisionGroup* group1, CollisionGroup* group2);

    struct Core;
    std::unique_ptr<Core> core_;
    static Registrar<OncollideCollisionDetector> registrar_;
};

} // namespace dart::collision
