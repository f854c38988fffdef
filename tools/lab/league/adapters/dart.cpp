// DART's own collision detector, and its detector by FCL.
#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include <assimp/scene.h>
#include <dart/collision/collision.hpp>
#include <dart/collision/dart/dart.hpp>
#include <dart/collision/fcl/fcl.hpp>
#include <dart/config.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/EllipsoidShape.hpp>
#include <dart/dynamics/MeshShape.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/SimpleFrame.hpp>
#include <dart/dynamics/SphereShape.hpp>

#include "common.hpp"

namespace {

namespace collision = dart::collision;
namespace dynamics = dart::dynamics;
using Eigen::Vector3d;

/// MeshShape deletes it.
aiScene* make_scene(const league_body& body)
{
    auto scene = std::make_unique<aiScene>();
    scene->mRootNode = new aiNode;
    scene->mMaterials = new aiMaterial* [scene->mNumMaterials = 1] { new aiMaterial };
    scene->mMeshes = new aiMesh* [scene->mNumMeshes = 1] { new aiMesh };
    scene->mRootNode->mMeshes = new unsigned[scene->mRootNode->mNumMeshes = 1]{0};
    aiMesh& mesh = *scene->mMeshes[0];
    mesh.mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
    mesh.mVertices = new aiVector3D[mesh.mNumVertices = unsigned(body.vertex_count)];
    for (std::size_t i = 0; i < body.vertex_count; ++i) {
        const double* p = body.vertices + 3 * i;
        mesh.mVertices[i] = {ai_real(p[0]), ai_real(p[1]), ai_real(p[2])};
    }
    mesh.mFaces = new aiFace[mesh.mNumFaces = unsigned(body.triangle_count)];
    for (std::size_t i = 0; i < body.triangle_count; ++i) {
        mesh.mFaces[i].mIndices = new unsigned[mesh.mFaces[i].mNumIndices = 3];
        std::copy_n(body.triangles + 3 * i, 3, mesh.mFaces[i].mIndices);
    }
    return scene.release();
}

dynamics::ShapePtr make_shape(const league_body& body)
{
    const Vector3d size(body.size);
    switch (body.kind) {
    case LEAGUE_MESH:
    case LEAGUE_TERRAIN:
        return std::make_shared<dynamics::MeshShape>(Vector3d::Ones(), make_scene(body));
    case LEAGUE_SPHERE:
        return std::make_shared<dynamics::SphereShape>(size.x());
    case LEAGUE_BOX:
        return std::make_shared<dynamics::BoxShape>(2 * size);
    case LEAGUE_ELLIPSOID:
        return std::make_shared<dynamics::EllipsoidShape>(2 * size); // diameters
    case LEAGUE_HALF_SPACE:
        return std::make_shared<dynamics::PlaneShape>(Vector3d::UnitZ(), 0.0);
    default:
        throw std::domain_error("not used");
    }
}

std::shared_ptr<dynamics::SimpleFrame> make_frame(const league_body& body)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(body.rotation);
    pose.translation() = Vector3d(body.position);
    auto frame = std::make_shared<dynamics::SimpleFrame>(dynamics::Frame::World());
    frame->setShape(make_shape(body));
    frame->setTransform(pose);
    return frame;
}

class Pair final : public league::Query {
public:
    Pair(const league_case& asked, std::shared_ptr<collision::CollisionDetector> detector)
        : detector_(std::move(detector)), a_(make_frame(asked.a)), b_(make_frame(asked.b)),
          group_a_(detector_->createCollisionGroup(a_.get())), group_b_(detector_->createCollisionGroup(b_.get()))
    {
    }

    int answer(const league_case& asked, league_answer& answer) override
    {
        if (asked.question == LEAGUE_MEET) {
            answer.meet = group_a_->collide(group_b_.get(), collision::CollisionOption(false, 1));
            return LEAGUE_ANSWERED;
        }
        if (asked.question == LEAGUE_DISTANCE) return distance(answer);
        collision::CollisionResult result;
        answer.meet = group_a_->collide(group_b_.get(), collision::CollisionOption(true, 100), &result);
        contacts_.clear();
        for (const collision::Contact& contact : result.getContacts()) {
            // Its normal points to its first object.
            const Vector3d along =
                contact.collisionObject1->getShapeFrame() == a_.get() ? Vector3d(-contact.normal) : contact.normal;
            league_contact& copy = contacts_.emplace_back();
            std::copy_n(contact.point.data(), 3, copy.position);
            std::copy_n(along.data(), 3, copy.normal);
            copy.depth = contact.penetrationDepth;
        }
        if (asked.question == LEAGUE_CONTACTS) {
            answer.contacts = contacts_.data(), answer.contact_count = contacts_.size();
        } else if (!contacts_.empty()) {
            const league_contact& deepest = *std::max_element(
                contacts_.begin(), contacts_.end(), [](const auto& p, const auto& q) { return p.depth < q.depth; });
            answer.depth = deepest.depth;
            std::copy_n(deepest.normal, 3, answer.normal);
        }
        return LEAGUE_ANSWERED;
    }

private:
    int distance(league_answer& answer)
    {
        collision::DistanceResult result;
        group_a_->distance(group_b_.get(), collision::DistanceOption(true), &result);
        if (!result.found()) return LEAGUE_FAILED;
        answer.distance = std::max(0.0, result.minDistance);
        answer.meet = answer.distance == 0;
        answer.has_points = !answer.meet;
        const bool in_order = result.shapeFrame1 == a_.get();
        std::copy_n((in_order ? result.nearestPoint1 : result.nearestPoint2).data(), 3, answer.point_a);
        std::copy_n((in_order ? result.nearestPoint2 : result.nearestPoint1).data(), 3, answer.point_b);
        return LEAGUE_ANSWERED;
    }

    std::shared_ptr<collision::CollisionDetector> detector_;
    std::shared_ptr<dynamics::SimpleFrame> a_, b_;
    std::unique_ptr<collision::CollisionGroup> group_a_, group_b_;
    std::vector<league_contact> contacts_;
};

std::unique_ptr<league::Query> prepare(const league_case& asked)
{
    return std::make_unique<Pair>(asked, collision::DARTCollisionDetector::create());
}

std::unique_ptr<league::Query> prepare_fcl(const league_case& asked)
{
    if (league::needs_inside(asked)) return nullptr;
    auto detector = collision::FCLCollisionDetector::create();
    detector->setPrimitiveShapeType(collision::FCLCollisionDetector::PRIMITIVE);
    return std::make_unique<Pair>(asked, std::move(detector));
}

/// The detector warns about all other shapes, and about distances.
int supports(int question, int kind_a, int kind_b)
{
    const auto has = [](int kind) { return kind == LEAGUE_SPHERE || kind == LEAGUE_BOX; };
    return (question == LEAGUE_MEET || question == LEAGUE_DEPTH || question == LEAGUE_CONTACTS) && has(kind_a) &&
           has(kind_b);
}

/// Cylinders and cones become meshes of 16 sides in it, and it has no capsules and hulls. A contact of a mesh has the
/// depth of one triangle; GJK has no half-spaces.
int supports_fcl(int question, int kind_a, int kind_b)
{
    const auto both = [&](auto holds) { return holds(kind_a) && holds(kind_b); };
    const auto is_shape = [](int kind) {
        return kind == LEAGUE_SPHERE || kind == LEAGUE_BOX || kind == LEAGUE_ELLIPSOID;
    };
    switch (question) {
    case LEAGUE_MEET:
        return both(
            [&](int kind) { return is_shape(kind) || league::has_triangles(kind) || kind == LEAGUE_HALF_SPACE; });
    case LEAGUE_DISTANCE:
        return both([&](int kind) { return is_shape(kind) || league::has_triangles(kind); });
    case LEAGUE_DEPTH:
    case LEAGUE_CONTACTS:
        return both([&](int kind) { return is_shape(kind) || kind == LEAGUE_HALF_SPACE; });
    default:
        return 0;
    }
}

constexpr league_library libraries[] = {
    league::library_of<prepare>({
        .name = "dart",
        .settings = DART_VERSION "; DARTCollisionDetector, CollisionGroup::collide(), the deepest of 100 contacts",
        .source = "dart/collision/CollisionGroup.hpp, Contact.hpp; the detector's message for other shapes",
        .supports = supports,
    }),
    league::library_of<prepare_fcl>({
        .name = "dart-fcl",
        .settings =
            DART_VERSION "; FCLCollisionDetector with PRIMITIVE shapes; CollisionGroup::collide(), the deepest of 100 "
                         "contacts, distance(); vertices of meshes are single precision",
        .source = "dart/collision/fcl/FCLCollisionDetector.hpp, CollisionGroup.hpp, Contact.hpp, DistanceResult.hpp",
        .supports = supports_fcl,
        .bits = 32, // as its meshes
    }),
};

} // namespace

const league_library* league_open(int number)
{
    return league::library_at(libraries, number);
}
