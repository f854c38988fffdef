// FCL with each of its two solvers for convex bodies.
#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include <fcl/fcl.h>

#define LEAGUE_WITH_HULL_FACES
#include "common.hpp"

namespace {

using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;

fcl::Transform3d pose_of(const league_body& body)
{
    fcl::Transform3d pose = fcl::Transform3d::Identity();
    pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(body.rotation);
    pose.translation() = Eigen::Map<const Eigen::Vector3d>(body.position);
    return pose;
}

template <class Volume>
Geometry make_tree(const league_body& body)
{
    std::vector<fcl::Vector3d> vertices;
    for (std::size_t i = 0; i < body.vertex_count; ++i) vertices.emplace_back(body.vertices + 3 * i);
    std::vector<fcl::Triangle> triangles;
    for (std::size_t i = 0; i < body.triangle_count; ++i) {
        const std::uint32_t* t = body.triangles + 3 * i;
        triangles.emplace_back(t[0], t[1], t[2]);
    }
    auto tree = std::make_shared<fcl::BVHModel<Volume>>();
    if (tree->beginModel(int(triangles.size()), int(vertices.size())) != fcl::BVH_OK ||
        tree->addSubModel(vertices, triangles) != fcl::BVH_OK || tree->endModel() != fcl::BVH_OK)
        throw std::runtime_error("FCL made no tree");
    return tree;
}

Geometry make_hull(const league_body& body)
{
    const league::Hull hull = league::hull_of(body);
    auto points = std::make_shared<std::vector<fcl::Vector3d>>();
    for (const league::Vector& p : hull.points) points->emplace_back(p.data());
    auto faces = std::make_shared<std::vector<int>>();
    for (const league::Face& face : hull.faces) {
        faces->push_back(int(face.corners.size()));
        faces->insert(faces->end(), face.corners.begin(), face.corners.end());
    }
    return std::make_shared<fcl::Convexd>(points, int(hull.faces.size()), faces, true);
}

/// Throws if a cell is not one of the octree's.
Geometry make_octree(const league_body& body)
{
    const double side = body.size[0];
    auto tree = std::make_shared<octomap::OcTree>(side);
    for (std::size_t i = 0; i < body.vertex_count; ++i) {
        const double* centre = body.vertices + 3 * i;
        octomap::OcTreeKey key;
        if (!tree->coordToKeyChecked(centre[0], centre[1], centre[2], key)) throw std::out_of_range("far away");
        for (unsigned k = 0; k < 3; ++k)
            if (std::abs(tree->keyToCoord(key[k]) - centre[k]) > 1e-9 * side) throw std::domain_error("off the grid");
        tree->setNodeValue(key, tree->getClampingThresMaxLog(), true);
    }
    tree->updateInnerOccupancy(), tree->prune();
    return std::make_shared<fcl::OcTreed>(std::move(tree));
}

Geometry make_geometry(const league_body& body, bool moves = false)
{
    const double* size = body.size;
    switch (body.kind) {
    case LEAGUE_MESH:
    case LEAGUE_TERRAIN:
        return moves ? make_tree<fcl::RSSd>(body) : make_tree<fcl::OBBRSSd>(body);
    case LEAGUE_HULL:
        return make_hull(body);
    case LEAGUE_SPHERE:
        return std::make_shared<fcl::Sphered>(size[0]);
    case LEAGUE_CAPSULE:
        return std::make_shared<fcl::Capsuled>(size[0], 2 * size[1]);
    case LEAGUE_BOX:
        return std::make_shared<fcl::Boxd>(2 * size[0], 2 * size[1], 2 * size[2]);
    case LEAGUE_CYLINDER:
        return std::make_shared<fcl::Cylinderd>(size[0], 2 * size[1]);
    case LEAGUE_CONE:
        return std::make_shared<fcl::Coned>(size[0], 2 * size[1]);
    case LEAGUE_ELLIPSOID:
        return std::make_shared<fcl::Ellipsoidd>(size[0], size[1], size[2]);
    case LEAGUE_HALF_SPACE:
        return std::make_shared<fcl::Halfspaced>(fcl::Vector3d::UnitZ(), 0);
    case LEAGUE_CELLS:
        return make_octree(body);
    default:
        throw std::domain_error("an unknown kind");
    }
}

/// The pairs in FCL's tables (narrowphase/detail/*_func_matrix-inl.h), without half-spaces where it needs distances:
/// GJK crashes on them, as they have no support function. A contact has the depth of one triangle or cell, so only
/// bodies without either are queried for the depth of the whole.
int supports(int question, int kind_a, int kind_b)
{
    const auto both = [&](auto holds) { return holds(kind_a) && holds(kind_b); };
    switch (question) {
    case LEAGUE_MEET:
    case LEAGUE_CONTACTS:
        return both([](int kind) { return kind >= 0 && kind < LEAGUE_KIND_COUNT; });
    case LEAGUE_DISTANCE:
        return both([](int kind) { return kind >= 0 && kind < LEAGUE_KIND_COUNT && kind != LEAGUE_HALF_SPACE; });
    case LEAGUE_DEPTH:
        return both([](int kind) { return league::is_convex(kind) || kind == LEAGUE_HALF_SPACE; });
    case LEAGUE_CAST:
    case LEAGUE_TURN:
        return both([](int kind) {
            return league::has_triangles(kind) || (league::is_convex(kind) && kind != LEAGUE_ELLIPSOID);
        });
    default:
        return question == LEAGUE_PAIRS;
    }
}

template <fcl::GJKSolverType solver>
struct Pair final : league::Query {
    Geometry a, b;
    fcl::Transform3d pose_a, pose_b, end_b;
    bool are_shapes;
    std::vector<league_contact> contacts;

    explicit Pair(const league_case& asked)
        : a(make_geometry(asked.a, moves(asked))), b(make_geometry(asked.b, moves(asked))), pose_a(pose_of(asked.a)),
          pose_b(pose_of(asked.b)),
          end_b(Eigen::Translation3d(Eigen::Map<const Eigen::Vector3d>(asked.motion)) * pose_b),
          are_shapes(league::is_convex(asked.a.kind) && league::is_convex(asked.b.kind))
    {
        a->computeLocalAABB(), b->computeLocalAABB();
    }

    static bool moves(const league_case& asked)
    {
        return asked.question == LEAGUE_CAST || asked.question == LEAGUE_TURN;
    }

    int meet(league_answer& answer) const
    {
        fcl::CollisionRequestd request(1, false);
        request.gjk_solver_type = solver;
        fcl::CollisionResultd result;
        answer.meet = fcl::collide(a.get(), pose_a, b.get(), pose_b, request, result) > 0;
        return LEAGUE_ANSWERED;
    }

    int distance(league_answer& answer) const
    {
        fcl::DistanceRequestd request(true);
        request.gjk_solver_type = solver;
        fcl::DistanceResultd result;
        answer.distance = std::max(0.0, fcl::distance(a.get(), pose_a, b.get(), pose_b, request, result));
        answer.meet = answer.distance == 0;
        // distance_request.h promises points on the surfaces only for these.
        answer.has_points = !answer.meet && are_shapes && solver == fcl::GST_LIBCCD;
        if (answer.has_points) {
            std::copy_n(result.nearest_points[0].data(), 3, answer.point_a);
            std::copy_n(result.nearest_points[1].data(), 3, answer.point_b);
        }
        return LEAGUE_ANSWERED;
    }

    void find_contacts()
    {
        fcl::CollisionRequestd request(100, true);
        request.gjk_solver_type = solver;
        fcl::CollisionResultd result;
        fcl::collide(a.get(), pose_a, b.get(), pose_b, request, result);
        contacts.clear();
        for (std::size_t k = 0; k < result.numContacts(); ++k) {
            const fcl::Contactd& found = result.getContact(k);
            // It points from o1 to o2, and collide() may have exchanged the two.
            const fcl::Vector3d along = found.o1 == a.get() ? found.normal : fcl::Vector3d(-found.normal);
            league_contact& contact = contacts.emplace_back();
            std::copy_n(found.pos.data(), 3, contact.position);
            std::copy_n(along.data(), 3, contact.normal);
            contact.depth = found.penetration_depth;
        }
    }

    int depth(league_answer& answer)
    {
        find_contacts();
        const auto deepest = std::max_element(contacts.begin(), contacts.end(),
                                              [](const auto& p, const auto& q) { return p.depth < q.depth; });
        if (deepest == contacts.end()) return LEAGUE_ANSWERED;
        answer.meet = 1, answer.depth = deepest->depth;
        std::copy_n(deepest->normal, 3, answer.normal);
        return LEAGUE_ANSWERED;
    }

    int list_contacts(league_answer& answer)
    {
        find_contacts();
        answer.meet = !contacts.empty();
        answer.contacts = contacts.data(), answer.contact_count = contacts.size();
        return LEAGUE_ANSWERED;
    }

    /// TBVMotionBoundVisitor knows only RSS: with all other trees, the bound of a shape that moves toward a mesh is 0.
    /// FCL itself loses contacts of them even so, as conservativeAdvancementMeshShapeOriented() leaves the bounding
    /// volume of the shape where it was at the beginning. With the shape first, FCL calls itself without end.
    int cast(league_answer& answer) const
    {
        fcl::ContinuousCollisionRequestd request;
        request.gjk_solver_type = solver;
        request.ccd_motion_type = fcl::CCDM_TRANS;
        request.ccd_solver_type = fcl::CCDC_CONSERVATIVE_ADVANCEMENT;
        fcl::ContinuousCollisionResultd result;
        fcl::continuousCollide(a.get(), pose_a, pose_a, b.get(), pose_b, end_b, request, result);
        answer.meet = result.is_collide;
        answer.time = result.time_of_contact;
        answer.error = request.toc_err;
        return LEAGUE_ANSWERED;
    }

    /// InterpMotion moves a point of b on a line and turns b around it by the shorter way, both at a constant rate. Its
    /// constructor of two poses alone leaves that point uninitialised.
    int turn(const league_case& asked, league_answer& answer) const
    {
        fcl::ContinuousCollisionRequestd request;
        request.gjk_solver_type = solver;
        request.ccd_motion_type = fcl::CCDM_LINEAR;
        request.ccd_solver_type = fcl::CCDC_CONSERVATIVE_ADVANCEMENT;
        const fcl::TranslationMotion<double> rest(pose_a, pose_a);
        const int pieces = 1 + int(league::length_of({asked.turn[0], asked.turn[1], asked.turn[2]}) / 3);
        answer.error = request.toc_err / pieces;
        for (int k = 0; k < pieces; ++k) {
            const fcl::Transform3d from = pose_of(league::b_at(asked, double(k) / pieces)),
                                   to = pose_of(league::b_at(asked, double(k + 1) / pieces));
            const fcl::InterpMotion<double> motion(from.linear(), from.translation(), to.linear(), to.translation(),
                                                   fcl::Vector3d::Zero());
            fcl::ContinuousCollisionResultd result;
            fcl::continuousCollide(a.get(), &rest, b.get(), &motion, request, result);
            if (!result.is_collide) continue;
            answer.meet = 1, answer.time = (k + result.time_of_contact) / pieces;
            break;
        }
        return LEAGUE_ANSWERED;
    }

    int answer(const league_case& asked, league_answer& answer) override
    {
        switch (asked.question) {
        case LEAGUE_MEET:
            return meet(answer);
        case LEAGUE_DISTANCE:
            return distance(answer);
        case LEAGUE_DEPTH:
            return depth(answer);
        case LEAGUE_CONTACTS:
            return list_contacts(answer);
        case LEAGUE_TURN:
            return turn(asked, answer);
        default:
            return cast(answer);
        }
    }
};

struct Boxes final : league::Query {
    std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
    fcl::DynamicAABBTreeCollisionManagerd manager;
    std::vector<std::uint32_t> pairs;

    explicit Boxes(const league_case& asked)
    {
        std::vector<fcl::CollisionObjectd*> all;
        for (std::size_t i = 0; i < asked.body_count; ++i) {
            const league_body& body = asked.bodies[i];
            all.push_back(
                objects.emplace_back(std::make_unique<fcl::CollisionObjectd>(make_geometry(body), pose_of(body)))
                    .get());
            all.back()->setUserData(reinterpret_cast<void*>(i));
        }
        manager.registerObjects(all);
        manager.setup();
    }

    static bool take(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* pairs)
    {
        if (a->getAABB().overlap(b->getAABB()))
            for (const fcl::CollisionObjectd* object : {a, b})
                static_cast<std::vector<std::uint32_t>*>(pairs)->push_back(
                    std::uint32_t(reinterpret_cast<std::uintptr_t>(object->getUserData())));
        return false; // It goes on.
    }

    int answer(const league_case&, league_answer& answer) override
    {
        pairs.clear();
        if (!manager.empty()) manager.collide(&pairs, take);
        answer.pair_count = pairs.size() / 2;
        answer.pairs = pairs.data();
        return LEAGUE_ANSWERED;
    }
};

template <fcl::GJKSolverType solver>
std::unique_ptr<league::Query> prepare(const league_case& asked)
{
    if (league::needs_inside(asked)) return nullptr;
    if (asked.question == LEAGUE_PAIRS) return std::make_unique<Boxes>(asked);
    return std::make_unique<Pair<solver>>(asked);
}

#define LEAGUE_FCL_USE                                                                                                 \
    "0.7.0; BVHModel<OBBRSS> (motions: RSS), Convex, OcTree; collide(), distance(), at most 100 contacts (depth: "     \
    "the deepest), continuousCollide() by conservative advancement (turns: InterpMotion, in pieces of less than a "    \
    "half turn), DynamicAABBTreeCollisionManager; "

constexpr const char* source = "fcl/narrowphase/collision_request.h, distance_request.h, contact.h, "
                               "continuous_collision.h, continuous_collision_request.h, math/motion/interp_motion.h";

constexpr league_library libraries[] = {
    league::library_of<prepare<fcl::GST_LIBCCD>>({
        .name = "fcl",
        .settings = LEAGUE_FCL_USE "GST_LIBCCD, the default",
        .source = source,
        .supports = supports,
        .precision = 1e-6, // gjk_tolerance, distance_tolerance
    }),
    league::library_of<prepare<fcl::GST_INDEP>>({
        .name = "fcl-indep",
        .settings = LEAGUE_FCL_USE "GST_INDEP",
        .source = source,
        .supports = supports,
        .precision = 1e-6,
    }),
};

} // namespace

const league_library* league_open(int number)
{
    return league::library_at(libraries, number);
}
