#include "peers/peers.hpp"

#include <array>
#include <cmath>
#include <cstdarg>
#include <map>

#include <ode/ode.h>

namespace oncollide::tools {
namespace {

/// ODE must be initialised once per program, and closed at its end. It prints a message for each pair of meshes with
/// many contacts; these are dropped.
void start_ode()
{
    static const struct Library {
        Library()
        {
            dInitODE2(0), dSetMessageHandler([](int, const char*, va_list) {});
        }
        ~Library() { dCloseODE(); }
    } library;
}

/// A mesh in ODE's form. ODE keeps pointers into these arrays.
class OdeMeshData {
public:
    explicit OdeMeshData(const Mesh& mesh) : id(dGeomTriMeshDataCreate())
    {
        for (const Eigen::Vector3d& v : mesh.vertices) vertices_.insert(vertices_.end(), {v.x(), v.y(), v.z()});
        for (const Triangle& t : mesh.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
        dGeomTriMeshDataBuildDouble(id, vertices_.data(), 3 * sizeof(double), int(mesh.vertices.size()),
                                    indices_.data(), int(indices_.size()), 3 * sizeof(dTriIndex));
    }
    ~OdeMeshData() { dGeomTriMeshDataDestroy(id); }
    OdeMeshData(const OdeMeshData&) = delete;
    OdeMeshData& operator=(const OdeMeshData&) = delete;

    const dTriMeshDataID id;

private:
    std::vector<double> vertices_;
    std::vector<dTriIndex> indices_;
};

void place(dGeomID geometry, const Eigen::Isometry3d& pose)
{
    const Eigen::Vector3d& p = pose.translation();
    dMatrix3 rotation{};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) rotation[4 * row + column] = pose.linear()(row, column);
    dGeomSetPosition(geometry, p.x(), p.y(), p.z());
    dGeomSetRotation(geometry, rotation);
}

/// Collision queries only: ODE merges contacts before it returns them, so pairs of triangles are lost.
class OdeNarrowPeer final : public NarrowPeer {
public:
    OdeNarrowPeer(const Mesh& a, const Mesh& b)
        : data_a_((start_ode(), a)), data_b_(b), a_(dCreateTriMesh(nullptr, data_a_.id, nullptr, nullptr, nullptr)),
          b_(dCreateTriMesh(nullptr, data_b_.id, nullptr, nullptr, nullptr))
    {
    }
    ~OdeNarrowPeer() override { dGeomDestroy(a_), dGeomDestroy(b_); }

    bool collides(const Eigen::Isometry3d& b) override
    {
        place(b_, b);
        dContactGeom contact;
        return dCollide(a_, b_, int(1u | CONTACTS_UNIMPORTANT), &contact, sizeof contact) > 0;
    }

private:
    OdeMeshData data_a_, data_b_;
    dGeomID a_, b_;
};

/// A convex polyhedron in ODE's form. ODE keeps pointers into these arrays.
class OdePolyhedron {
public:
    explicit OdePolyhedron(const Mesh& surface)
    {
        for (const Eigen::Vector3d& v : surface.vertices) points_.insert(points_.end(), {v.x(), v.y(), v.z()});
        for (const Triangle& t : surface.triangles) {
            const Eigen::Vector3d &a = surface.vertices[t[0]], &b = surface.vertices[t[1]], &c = surface.vertices[t[2]];
            const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
            planes_.insert(planes_.end(), {normal.x(), normal.y(), normal.z(), normal.dot(a)});
            polygons_.insert(polygons_.end(), {3, t[0], t[1], t[2]});
        }
    }
    dGeomID make() const
    {
        return dCreateConvex(nullptr, planes_.data(), unsigned(planes_.size() / 4), points_.data(),
                             unsigned(points_.size() / 3), polygons_.data());
    }

private:
    std::vector<double> points_, planes_;
    std::vector<unsigned> polygons_;
};

/// A terrain in ODE's form: y is up, and z runs against our y.
class OdeTerrain {
public:
    explicit OdeTerrain(const Terrain& terrain) : id(dGeomHeightfieldDataCreate())
    {
        std::vector<double> heights;
        for (std::uint32_t r = terrain.rows(); r-- > 0;)
            for (std::uint32_t c = 0; c < terrain.columns(); ++c) heights.push_back(terrain.point(c, r).z());
        const Eigen::Vector3d first = terrain.point(0, 0);
        const Eigen::Vector3d last = terrain.point(terrain.columns() - 1, terrain.rows() - 1);
        dGeomHeightfieldDataBuildDouble(id, heights.data(), 1, last.x() - first.x(), last.y() - first.y(),
                                        int(terrain.columns()), int(terrain.rows()), 1, 0, 0, 0);
        from_ode = Eigen::Translation3d((first.x() + last.x()) / 2, (first.y() + last.y()) / 2, 0) *
                   Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX());
    }
    ~OdeTerrain() { dGeomHeightfieldDataDestroy(id); }
    OdeTerrain(const OdeTerrain&) = delete;
    OdeTerrain& operator=(const OdeTerrain&) = delete;

    const dHeightfieldDataID id;
    Eigen::Isometry3d from_ode;
};

/// Points of a round shape that ODE lacks.
ConvexHull points_of(const Cone& cone)
{
    ConvexHull hull{{{0, 0, cone.length / 2}}};
    for (int k = 0; k < 32; ++k)
        hull.points.emplace_back(cone.radius * std::cos(k * M_PI / 16), cone.radius * std::sin(k * M_PI / 16),
                                 -cone.length / 2);
    return hull;
}

ConvexHull points_of(const Ellipsoid& ellipsoid)
{
    constexpr double outside = 1.01; // so that the faces are inside by as much as the corners are outside
    const Eigen::Vector3d axes = outside * ellipsoid.semi_axes;
    ConvexHull hull{{{0, 0, axes.z()}, {0, 0, -axes.z()}}};
    for (int row = 1; row < 8; ++row)
        for (int k = 0; k < 16; ++k) {
            const double v = row * M_PI / 8, u = k * M_PI / 8;
            hull.points.push_back(
                axes.cwiseProduct(Eigen::Vector3d(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), std::cos(v))));
        }
    return hull;
}

class OdeContactPeer final : public ContactPeer {
public:
    explicit OdeContactPeer(std::span<const ContactPeerBody> bodies) : space_((start_ode(), dHashSpaceCreate(nullptr)))
    {
        dSpaceSetCleanup(space_, 0);
        for (const ContactPeerBody& body : bodies) {
            geometries_.push_back(make(*body.geometry));
            dGeomSetCategoryBits(geometries_.back(), body.is_static ? 1 : 2);
            dGeomSetCollideBits(geometries_.back(), body.is_static ? 2 : 3);
            const auto terrain = terrains_.find(body.geometry);
            from_ode_.push_back(terrain == terrains_.end() ? nullptr : &terrain->second->from_ode);
            place(geometries_.size() - 1, body.pose);
            dSpaceAdd(space_, geometries_.back());
        }
    }
    ~OdeContactPeer() override
    {
        for (const dGeomID g : geometries_) dGeomDestroy(g);
        dSpaceDestroy(space_);
    }
    void place(std::span<const Eigen::Isometry3d> poses) override
    {
        for (std::size_t i = 0; i < poses.size(); ++i) place(i, poses[i]);
    }
    std::size_t contacts() override
    {
        count_ = 0;
        dSpaceCollide(space_, this, take);
        return count_;
    }
    std::size_t contacts_of(std::span<const BodyPair> pairs) override
    {
        count_ = 0;
        for (const auto& [a, b] : pairs) take(this, geometries_[a], geometries_[b]);
        return count_;
    }

private:
    void place(std::size_t i, const Eigen::Isometry3d& pose)
    {
        tools::place(geometries_[i], from_ode_[i] ? pose * *from_ode_[i] : pose);
    }
    static void take(void* data, dGeomID a, dGeomID b)
    {
        std::array<dContactGeom, 250> found; // as in DART
        static_cast<OdeContactPeer*>(data)->count_ +=
            static_cast<std::size_t>(dCollide(a, b, int(found.size()), found.data(), sizeof(dContactGeom)));
    }
    dGeomID make(const Geometry& geometry)
    {
        if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) {
            auto& data = meshes_[&geometry];
            if (!data) {
                data = std::make_unique<OdeMeshData>(*mesh);
                dGeomTriMeshDataPreprocess2(data->id, 1u << dTRIDATAPREPROCESS_BUILD_FACE_ANGLES, nullptr); // for hulls
            }
            return dCreateTriMesh(nullptr, data->id, nullptr, nullptr, nullptr);
        }
        if (const auto* terrain = std::get_if<Terrain>(&geometry.data)) {
            auto& data = terrains_[&geometry];
            if (!data) data = std::make_unique<OdeTerrain>(*terrain);
            return dCreateHeightfield(nullptr, data->id, 1);
        }
        const Shape& shape = std::get<Shape>(geometry.data);
        if (const auto* box = std::get_if<Box>(&shape)) {
            const Eigen::Vector3d size = 2 * box->half;
            return dCreateBox(nullptr, size.x(), size.y(), size.z());
        }
        if (const auto* sphere = std::get_if<Sphere>(&shape)) return dCreateSphere(nullptr, sphere->radius);
        if (const auto* s = std::get_if<Capsule>(&shape)) return dCreateCapsule(nullptr, s->radius, s->length);
        if (const auto* s = std::get_if<Cylinder>(&shape)) return dCreateCylinder(nullptr, s->radius, s->length);
        auto& polyhedron = polyhedra_[&geometry];
        if (!polyhedron) {
            const auto* cone = std::get_if<Cone>(&shape);
            const auto* ellipsoid = std::get_if<Ellipsoid>(&shape);
            const Shape hull = cone        ? Shape(points_of(*cone))
                               : ellipsoid ? Shape(points_of(*ellipsoid))
                                           : Shape(std::get<ConvexHull>(shape));
            polyhedron = std::make_unique<OdePolyhedron>(bounding_mesh_of(hull).mesh);
        }
        return polyhedron->make();
    }

    dSpaceID space_;
    std::map<const Geometry*, std::unique_ptr<OdeMeshData>> meshes_;
    std::map<const Geometry*, std::unique_ptr<OdeTerrain>> terrains_;
    std::map<const Geometry*, std::unique_ptr<OdePolyhedron>> polyhedra_;
    std::vector<dGeomID> geometries_;
    std::vector<const Eigen::Isometry3d*> from_ode_; ///< of a body's terrain
    std::size_t count_ = 0;
};

} // namespace

void add_ode(Contenders& all)
{
    all.narrow.all.push_back({.name = "ode",
                              .what = "ODE dCollide of two meshes, one contact",
                              .promise = Promise::approximate,
                              .least = 2,
                              .make = maker<OdeNarrowPeer>()});
    all.contacts.all.push_back({.name = "ode",
                                .what = "ODE dCollide, at most 250 contacts a pair; cones and ellipsoids as hulls",
                                .promise = Promise::approximate,
                                .make = maker<OdeContactPeer>()});
}

} // namespace oncollide::tools
