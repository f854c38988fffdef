// The World of a detector, and DART's objects and groups that show it.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <dart/collision/CollisionFilter.hpp>
#include <dart/collision/CollisionGroup.hpp>
#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/CollisionOption.hpp>
#include <dart/collision/CollisionResult.hpp>

#include <oncollide/dart/detector.hpp>
#include <oncollide/pipeline/world.hpp>

namespace dart::dynamics {
class SoftMeshShape;
}

namespace dart::collision {

namespace oncollide_client {

/// The model of a version of a shape; removed with its last user.
struct ShapeModel {
    using Key = std::pair<std::size_t, std::size_t>; ///< the shape's number and version
    oncollide::World& world;
    oncollide::ModelId id; ///< null: the shape has none
    Eigen::Isometry3d pose;
    const dynamics::SoftMeshShape* soft; ///< null: no soft mesh
    bool is_plane;
    ShapeModel(oncollide::World& of, const dynamics::Shape& shape, bool solid_heightmaps);
    ~ShapeModel();
    ShapeModel(const ShapeModel&) = delete;
    ShapeModel& operator=(const ShapeModel&) = delete;
};

/// The sides of a query that an object is on, as a set: 1, 2, or 3 for both.
using Sides = std::uint32_t;

class Object final : public CollisionObject {
public:
    Object(CollisionDetector* detector, const dynamics::ShapeFrame* frame) : CollisionObject(detector, frame) {}

    ShapeModel::Key key{};
    std::shared_ptr<ShapeModel> model;
    oncollide::BodyId body; ///< null: no model
    Sides sides = 0;
    std::size_t order = 0; ///< in the groups of the query

protected:
    void updateEngineData() override {} // OncollideCollisionDetector::Core::update() does it
};

/// The World holds the objects; a group only lists them.
class Group final : public CollisionGroup {
public:
    using CollisionGroup::CollisionGroup;

    template <class Visit>
    void each_object(Visit&& visit) const
    {
        for (const auto& info : mObjectInfoList) visit(static_cast<Object&>(*info->mObject));
    }

protected:
    void initializeEngineData() override {}
    void addCollisionObjectToEngine(CollisionObject*) override {}
    void addCollisionObjectsToEngine(const std::vector<CollisionObject*>&) override {}
    void removeCollisionObjectFromEngine(CollisionObject*) override {}
    void removeAllCollisionObjectsFromEngine() override {}
    void updateCollisionGroupEngineData() override {}
};

} // namespace oncollide_client

struct OncollideCollisionDetector::Core {
    using Object = oncollide_client::Object;
    using ShapeModel = oncollide_client::ShapeModel;

    explicit Core(const OncollideOptions& chosen);

    void add(Object& object);
    void remove(Object& object);
    /// Takes the object's shape as it is now.
    void refresh(Object& object);
    /// Takes the object's pose; the shape, too, if it changed.
    void update(Object& object);
    /// Updates the objects of both groups, and limits the calls that follow to pairs of an object of `a` and one of
    /// `b`.
    void select(const oncollide_client::Group& a, const oncollide_client::Group& b);

    bool collide(const CollisionOption& option, CollisionResult* result);
    double distance(const DistanceOption& option, DistanceResult* result);
    bool raycast(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const RaycastOption& option,
                 RaycastResult* result);

    OncollideOptions options;
    oncollide::World world;

private:
    Object& object_of(oncollide::BodyId body) const { return *by_slot_[index(body)]; }
    void choose(std::span<const oncollide::CandidatePair> pairs, std::span<oncollide::PairChoice> choices) const;
    static constexpr std::size_t none = ~std::size_t{0};
    struct Pair {
        Object *a, *b;                         ///< a comes first in the groups
        bool certain, soft;                    ///< they certainly meet; one of them is soft
        const oncollide::ManifoldLists* lists; ///< these hold its manifold,
        std::size_t place;                     ///< here; none: it has no region
    };
    struct Found {
        std::size_t rank; ///< the pair's deepest is 0
        std::pair<oncollide::FeatureBits, oncollide::FeatureBits> features;
        Contact contact;
    };
    void find_pairs(std::span<const oncollide::PairResult> results);
    void add_contacts(const Pair& pair);
    void add_contact(const Pair& pair, const oncollide::ManifoldPoint& point);
    void keep_deepest(std::size_t most);

    std::map<ShapeModel::Key, std::weak_ptr<ShapeModel>> models_;
    std::vector<Object*> objects_, by_slot_;
    std::vector<Object*> selected_; ///< the objects of the query with a model, in order
    const CollisionFilter* filter_ = nullptr;
    bool warned_of_cut_ = false, warned_of_pose_ = false;

    // Results of one collide().
    std::vector<Pair> pairs_;
    std::vector<oncollide::PairOfBodies> soft_pairs_;
    oncollide::ManifoldLists soft_manifolds_;
    std::vector<Found> found_;
};

} // namespace dart::collision
