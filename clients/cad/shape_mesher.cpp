#include "shape_mesher.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include <BRepAdaptor_Curve.hxx>
#include <BRepAdaptor_Surface.hxx>
#include <BRepBndLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <ShapeAnalysis_Surface.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopTools_ShapeMapHasher.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <gp_Trsf.hxx>

namespace oncollide::cad {
namespace {

/// The stated deflection is the largest measured distance times this factor, because samples miss the largest one.
constexpr double margin = 1.25;
constexpr double angle = 0.5; ///< largest angle between neighbouring chords of a curve, radians

/// Largest distances of a mesh from its shape, in the unit of the shape.
class Deviation {
public:
    void add(double distance) { most_ = std::max(most_, distance); }
    double most() const { return most_; }

private:
    double most_ = 0;
};

/// Distances of points from a face's surface.
class SurfaceGap {
public:
    /// @param enough  a distance below it is not searched for a smaller one
    SurfaceGap(const TopoDS_Face& face, double enough) : surface_(face, false), enough_(enough)
    {
        TopLoc_Location location;
        if (const Handle(Geom_Surface) surface = BRep_Tool::Surface(face, location); !surface.IsNull()) {
            projection_ = new ShapeAnalysis_Surface(surface);
            to_surface_ = location.Transformation().Inverted();
            scale_ = std::abs(location.Transformation().ScaleFactor());
        }
    }

    /// Each point of the surface bounds the distance. The point at the parameters lies beside the nearest one where
    /// parameters run unevenly; steps of Newton along the tangent plane lead towards it. They fail at poles.
    double of(const gp_Pnt& point, gp_XY parameters)
    {
        double least = HUGE_VAL;
        for (int step = 0; step < 4; ++step) {
            gp_Pnt on;
            gp_Vec du, dv;
            surface_.D1(parameters.X(), parameters.Y(), on, du, dv);
            const gp_Vec to(on, point);
            const double distance = to.Magnitude();
            if (!(distance < least)) break;
            least = distance;
            const double uu = du.Dot(du), uv = du.Dot(dv), vv = dv.Dot(dv), det = uu * vv - uv * uv;
            if (!(det > 1e-12 * uu * vv) || distance < enough_) break;
            const double pu = to.Dot(du), pv = to.Dot(dv);
            parameters += gp_XY((vv * pu - uv * pv) / det, (uu * pv - uv * pu) / det);
        }
        if (!(least > enough_) || projection_.IsNull()) return least;
        projection_->ValueOfUV(point.Transformed(to_surface_), 1e-7);
        return std::min(least, scale_ * projection_->Gap());
    }

private:
    BRepAdaptor_Surface surface_;
    Handle(ShapeAnalysis_Surface) projection_;
    gp_Trsf to_surface_;
    double scale_ = 1, enough_;
};

/// Measures a face at the corners, on the edges and inside each triangle: between the point of the triangle and the
/// point of the surface nearby.
void measure(const TopoDS_Face& face, const Poly_Triangulation& mesh, const gp_Trsf& place, double enough,
             Deviation& deviation)
{
    if (!mesh.HasUVNodes()) return;
    SurfaceGap gap(face, enough);
    constexpr double third = 1. / 3, sixth = 1. / 6;
    constexpr double samples[][3] = {{1, 0, 0},
                                     {0, 1, 0},
                                     {0, 0, 1},
                                     {.5, .5, 0},
                                     {0, .5, .5},
                                     {.5, 0, .5},
                                     {third, third, third},
                                     {4 * sixth, sixth, sixth},
                                     {sixth, 4 * sixth, sixth},
                                     {sixth, sixth, 4 * sixth}};
    for (int i = 1; i <= mesh.NbTriangles(); ++i) {
        int n[3];
        mesh.Triangle(i).Get(n[0], n[1], n[2]);
        for (const auto& weight : samples) {
            gp_XYZ point;
            gp_XY at;
            for (int k = 0; k < 3; ++k) {
                point += weight[k] * mesh.Node(n[k]).Transformed(place).XYZ();
                at += weight[k] * mesh.UVNode(n[k]).XY();
            }
            deviation.add(gap.of(gp_Pnt(point), at));
        }
    }
}

/// Measures the chords of an edge against its curve, which bounds the flat faces beside it, too.
void measure(const TopoDS_Edge& edge, const Poly_PolygonOnTriangulation& polygon, const Poly_Triangulation& mesh,
             const gp_Trsf& place, Deviation& deviation)
{
    double first, last;
    if (BRep_Tool::Degenerated(edge) || BRep_Tool::Curve(edge, first, last).IsNull() || polygon.Parameters().IsNull())
        return;
    const BRepAdaptor_Curve curve(edge);
    const TColStd_Array1OfReal& at = polygon.Parameters()->Array1();
    for (int i = 1; i < polygon.NbNodes(); ++i) {
        const gp_Pnt a = mesh.Node(polygon.Node(i)).Transformed(place),
                     b = mesh.Node(polygon.Node(i + 1)).Transformed(place);
        const gp_Vec chord(a, b);
        const double length2 = chord.SquareMagnitude();
        for (const double part : {0., .25, .5, .75, 1.}) {
            const gp_Pnt on = curve.Value(at(i) + part * (at(i + 1) - at(i)));
            const double along = length2 > 0 ? std::clamp(gp_Vec(a, on).Dot(chord) / length2, 0., 1.) : 0;
            deviation.add(on.Distance(a.Translated(along * chord)));
        }
    }
}

/// Joins the vertices that faces share.
class Welder {
public:
    std::size_t add(const gp_Pnt& point)
    {
        points_.push_back(point), same_.push_back(same_.size());
        return same_.size() - 1;
    }
    std::size_t find(std::size_t i)
    {
        while (same_[i] != i) i = same_[i] = same_[same_[i]];
        return i;
    }
    /// The first of the two keeps its position.
    void join(std::size_t i, std::size_t k)
    {
        i = find(i), k = find(k);
        same_[std::max(i, k)] = std::min(i, k);
    }
    const gp_Pnt& point(std::size_t i) const { return points_[i]; }
    std::size_t size() const { return same_.size(); }

private:
    std::vector<gp_Pnt> points_;
    std::vector<std::size_t> same_;
};

/// Collects the triangles of faces.
class PieceMesh {
public:
    /// @param enough  a deviation that needs no closer look
    explicit PieceMesh(double enough) : enough_(enough) {}

    void add(const TopoDS_Face& face)
    {
        TopLoc_Location location;
        const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, location);
        ++faces_;
        if (mesh.IsNull() || mesh->NbTriangles() == 0) {
            ++missing_;
            return;
        }
        const gp_Trsf place = location.Transformation();
        const std::size_t first = welder_.size();
        for (int i = 1; i <= mesh->NbNodes(); ++i) welder_.add(mesh->Node(i).Transformed(place));
        const auto number = [&](int node) { return first + std::size_t(node) - 1; };
        for (TopExp_Explorer at(face, TopAbs_EDGE); at.More(); at.Next()) {
            const TopoDS_Edge& edge = TopoDS::Edge(at.Current()); // a seam occurs twice, with a polygon for each side
            const Handle(Poly_PolygonOnTriangulation) polygon = BRep_Tool::PolygonOnTriangulation(edge, mesh, location);
            if (polygon.IsNull()) continue;
            measure(edge, *polygon, *mesh, place, deviation_);
            join_edge(edge, *polygon, number);
        }
        measure(face, *mesh, place, enough_, deviation_);
        const bool turned = (face.Orientation() == TopAbs_REVERSED) != place.IsNegative();
        for (int i = 1; i <= mesh->NbTriangles(); ++i) {
            int n[3];
            mesh->Triangle(i).Get(n[0], n[1], n[2]);
            if (turned) std::swap(n[1], n[2]);
            corners_.push_back({number(n[0]), number(n[1]), number(n[2])});
        }
    }

    std::size_t faces() const { return faces_; }
    std::size_t missing() const { return missing_; }
    double deviation() const { return deviation_.most(); }

    Mesh take()
    {
        Mesh mesh;
        std::map<std::array<float, 3>, std::uint32_t> numbers;
        std::vector<std::uint32_t> number_of(welder_.size());
        double farthest = 0;
        for (std::size_t i = 0; i < welder_.size(); ++i) {
            if (welder_.find(i) != i) {
                number_of[i] = number_of[welder_.find(i)];
                continue;
            }
            const gp_Pnt& p = welder_.point(i);
            std::array<float, 3> rounded;
            for (int k = 0; k < 3; ++k) {
                const double x = metres_per_unit * p.Coord(k + 1);
                farthest = std::max(farthest, std::abs(x));
                rounded[std::size_t(k)] = float(x) + 0.f; // no -0
            }
            const auto [at, fresh] = numbers.try_emplace(rounded, std::uint32_t(mesh.vertices.size()));
            if (fresh) mesh.vertices.push_back(rounded);
            number_of[i] = at->second;
        }
        for (const auto& [a, b, c] : corners_) {
            const std::array<std::uint32_t, 3> t{number_of[a], number_of[b], number_of[c]};
            if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
        }
        // sqrt(3) times half the distance between floats of that size
        mesh.deflection = margin * metres_per_unit * deviation_.most() + 1.1e-7 * farthest;
        return mesh;
    }

private:
    template <class Number>
    void join_edge(const TopoDS_Edge& edge, const Poly_PolygonOnTriangulation& polygon, Number number)
    {
        const int count = polygon.NbNodes(), known = edges_.FindIndex(edge);
        std::vector<std::size_t> nodes(static_cast<std::size_t>(count));
        for (int i = 1; i <= count; ++i) nodes[std::size_t(i - 1)] = number(polygon.Node(i));
        if (BRep_Tool::Degenerated(edge)) {
            for (const std::size_t node : nodes) welder_.join(nodes[0], node);
        } else if (known == 0) {
            edges_.Add(edge);
            nodes_.push_back(nodes);
        } else if (const std::vector<std::size_t>& others = nodes_[std::size_t(known - 1)];
                   others.size() == nodes.size()) {
            for (std::size_t i = 0; i < nodes.size(); ++i) welder_.join(others[i], nodes[i]);
        }
        TopoDS_Vertex ends[2];
        TopExp::Vertices(TopoDS::Edge(edge.Oriented(TopAbs_FORWARD)), ends[0], ends[1]);
        for (int i = 0; i < 2; ++i) {
            if (ends[i].IsNull()) continue;
            const std::size_t node = i == 0 ? nodes.front() : nodes.back();
            if (const int vertex = vertices_.FindIndex(ends[i]))
                welder_.join(of_vertex_[std::size_t(vertex - 1)], node);
            else
                vertices_.Add(ends[i]), of_vertex_.push_back(node);
        }
    }

    Welder welder_;
    TopTools_IndexedMapOfShape edges_, vertices_; // equal up to their orientation
    std::vector<std::vector<std::size_t>> nodes_; ///< by edge
    std::vector<std::size_t> of_vertex_;
    std::vector<std::array<std::size_t, 3>> corners_;
    Deviation deviation_;
    double enough_;
    std::size_t faces_ = 0, missing_ = 0;
};

/// The faces of each solid; the last list has the faces outside of solids.
std::vector<std::vector<TopoDS_Face>> pieces_of(const TopoDS_Shape& shape)
{
    std::vector<std::vector<TopoDS_Face>> pieces;
    const auto add_faces = [](TopExp_Explorer at, std::vector<TopoDS_Face>& to) {
        for (; at.More(); at.Next()) to.push_back(TopoDS::Face(at.Current()));
    };
    for (TopExp_Explorer at(shape, TopAbs_SOLID); at.More(); at.Next())
        add_faces(TopExp_Explorer(at.Current(), TopAbs_FACE), pieces.emplace_back());
    std::vector<TopoDS_Face> others;
    add_faces(TopExp_Explorer(shape, TopAbs_FACE, TopAbs_SOLID), others);
    std::erase_if(pieces, [](const auto& faces) { return faces.empty(); });
    pieces.push_back(std::move(others));
    return pieces;
}

std::vector<PieceMesh> divide(const TopoDS_Shape& shape, const std::vector<std::vector<TopoDS_Face>>& pieces,
                              double deflection, double enough)
{
    BRepTools::Clean(shape); // of triangles that the file holds, and of an earlier try
    IMeshTools_Parameters parameters;
    parameters.Deflection = deflection / margin;
    parameters.Angle = angle;
    const BRepMesh_IncrementalMesh mesher(shape, parameters);
    std::vector<PieceMesh> meshes(pieces.size(), PieceMesh(enough));
    for (std::size_t i = 0; i < pieces.size(); ++i)
        for (const TopoDS_Face& face : pieces[i]) meshes[i].add(face);
    return meshes;
}

double most_deviation(const std::vector<PieceMesh>& meshes)
{
    double most = 0;
    for (const PieceMesh& mesh : meshes) most = std::max(most, mesh.deviation());
    return most;
}

} // namespace

std::vector<Piece> mesh_of(const TopoDS_Shape& shape, const std::string& name, double deflection,
                           std::vector<std::string>& warnings)
{
    const std::vector<std::vector<TopoDS_Face>> pieces = pieces_of(shape);
    if (pieces.size() == 1 && pieces[0].empty()) return {};
    Bnd_Box box;
    BRepBndLib::Add(shape, box, false);
    constexpr double most = 1e9; // 1,000 km
    if (box.IsVoid() || box.IsOpen() || !(box.CornerMin().XYZ().Modulus() < most) ||
        !(box.CornerMax().XYZ().Modulus() < most))
        throw Fault(bad_data, fmt::format("'{}' extends beyond 1,000 km from the origin, or to infinity", name));
    const double size = std::sqrt(box.SquareExtent());
    double wanted = deflection > 0 ? deflection / metres_per_unit : std::clamp(size / 1000, .01, 1.);
    std::vector<PieceMesh> meshes = divide(shape, pieces, wanted, wanted / margin);
    double finer = wanted;
    for (int tries = 0; tries < 3 && margin * most_deviation(meshes) > wanted; ++tries) {
        finer /= 2;
        std::vector<PieceMesh> better = divide(shape, pieces, finer, wanted / margin);
        const double earlier = most_deviation(meshes), now = most_deviation(better);
        if (now < earlier) meshes = std::move(better);
        if (!(now < 0.7 * earlier)) break; // more triangles do not help
    }
    if (const double reached = margin * most_deviation(meshes); reached > wanted)
        warnings.push_back(fmt::format("'{}': the mesh deviates by up to {:.3g} mm; {:.3g} mm could not be reached",
                                       name, reached, wanted));
    std::vector<Piece> result;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        if (meshes[i].missing())
            warnings.push_back(fmt::format("'{}': {} of {} faces could not be divided into triangles; they are missing",
                                           name, meshes[i].missing(), meshes[i].faces()));
        Mesh mesh = meshes[i].take();
        if (mesh.triangles.empty()) continue;
        const bool solid = i + 1 < meshes.size();
        result.push_back({solid ? fmt::format("solid {}", i + 1) : "sheets", std::move(mesh)});
    }
    if (result.size() == 1) result[0].name.clear();
    return result;
}

} // namespace oncollide::cad
