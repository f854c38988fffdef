#include "planted/planted_assembly.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include <oncollide/samples/generators.hpp>

#include "verify/cases/body_case.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

constexpr double spacing = 400; ///< mm between sites; geometry stays within half of that less 20 of its site
constexpr double size = 100;    ///< mm, the diagonal of a part

double as_float(double x)
{
    return double(float(x));
}

Mesh box_between(const Vector3d& least, const Vector3d& most)
{
    Mesh box = make_box_mesh({1, 1, 1});
    for (Vector3d& v : box.vertices)
        for (int axis = 0; axis < 3; ++axis) v[axis] = v[axis] < 0 ? least[axis] : most[axis];
    return make_mesh("box", std::move(box.vertices), std::move(box.triangles));
}

Mesh fitted(const Mesh& mesh)
{
    return transformed("part", mesh, size / mesh.bounds.diagonal(), mesh.bounds.centre());
}

/// Adds parts and pairs, one site after the other.
class Planter {
public:
    explicit Planter(const PlantedOptions& options) : options_(options), meshes_(options.meshes)
    {
        const int n = options.triangles;
        if (meshes_.empty())
            meshes_ = {make_sphere_mesh(1, n), make_torus_mesh(1, 0.35, n), make_torus_knot_mesh(2, 3, 1, 0.4, 0.2, n),
                       make_gear_mesh(std::max(n / 16, 3), 0.8, 1, 0.5, 0.3), make_sphere_mesh(2, n)};
        for (Mesh& mesh : meshes_) mesh = fitted(mesh);
        side_ = std::size_t(std::ceil(std::cbrt(double(options.parts))));
    }

    PlantedAssembly run()
    {
        while (made_.parts.size() < options_.parts) {
            middle_ = spacing *
                      Vector3d(double(place_ % side_), double(place_ / side_ % side_), double(place_ / side_ / side_));
            const bool two = made_.parts.size() + 2 <= options_.parts;
            if (two && place_ % options_.every == options_.every - 1)
                plant(planted_++);
            else
                add("part", next_mesh());
            ++place_;
        }
        return std::move(made_);
    }

private:
    const Mesh& next_mesh() { return meshes_[used_++ % meshes_.size()]; }

    /// Adds a part in the middle of the site. Returns its name.
    std::string add(const char* what, const Mesh& mesh, const Vector3d& off = Vector3d::Zero())
    {
        std::vector<Vector3d> vertices = mesh.vertices;
        for (Vector3d& v : vertices) v = (v + middle_ + off).unaryExpr(&as_float);
        made_.triangles += mesh.triangles.size();
        std::string name = fmt::format("{}-{:05}", what, made_.parts.size());
        made_.parts.push_back({name, make_mesh(name, std::move(vertices), mesh.triangles)});
        return name;
    }
    std::string add_placed(const char* what, const Mesh& mesh)
    {
        const Vector3d middle = std::exchange(middle_, Vector3d::Zero());
        std::string name = add(what, mesh);
        middle_ = middle;
        return name;
    }

    /// Adds a block beside the last part. Its nearest face is `gap` beyond the part's vertex with the largest x; below
    /// 0: inside. Returns the gap after rounding to floats.
    double add_block(double gap)
    {
        const Aabb box = made_.parts.back().mesh.bounds;
        const double face = as_float(box.max.x() + gap);
        const std::string part = made_.parts.back().name;
        add_placed("block", box_between({face, box.min.y() - 20, box.min.z() - 20},
                                        {face + 50, box.max.y() + 20, box.max.z() + 20}));
        return face - box.max.x();
    }
    void expect(ClashKind kind, double depth = -1, double thickness = -1, double gap = -1)
    {
        const std::size_t n = made_.parts.size();
        made_.pairs.push_back({made_.parts[n - 2].name, made_.parts[n - 1].name, kind, depth, thickness, gap});
    }
    void plant_beside(double gap)
    {
        add("part", next_mesh());
        const double made = add_block(gap);
        if (made < 0) expect(ClashKind::crossing, -made);
        if (made == 0) expect(ClashKind::touching, 0);
        if (made > 0 && made < options_.clearance) expect(ClashKind::near, -1, -1, made);
    }
    void plant_in_crate(bool hollow)
    {
        add("part", next_mesh());
        Aabb box = made_.parts.back().mesh.bounds;
        const double margin = 5 + 2 * options_.clearance;
        box.min.array() -= margin, box.max.array() += margin;
        const Mesh inner = box_between(box.min, box.max);
        box.min.array() -= 10, box.max.array() += 10;
        add_placed("crate", hollow ? joined(box_between(box.min, box.max), flipped(inner)) : inner);
        if (!hollow) expect(ClashKind::enclosed);
    }

    void plant(std::size_t kind)
    {
        const double clearance = options_.clearance;
        const auto box = [](double x, double y, double z) { return make_box_mesh({x, y, z}); };
        switch (kind % 14) {
        case 0: // deep, and barely
        case 1:
            return plant_beside(kind % 14 == 0 ? -8 : -0.05);
        case 2:
            return plant_beside(0);
        case 3: // near, and slightly too far
        case 4:
            return plant_beside(kind % 14 == 3 ? 0.25 * clearance : 0.98 * clearance);
        case 5:
        case 6:
            return plant_beside(kind % 14 == 5 ? 1.02 * clearance : 5 * clearance);
        case 7:
        case 8:
            return plant_in_crate(kind % 14 == 8);
        case 9: // coincident faces
            add("plate", box(40, 30, 5)), add("plate", box(20, 20, 5), {0, 0, 10});
            return expect(ClashKind::touching, 0, 0);
        case 10: // crossing without a vertex of one inside the other
            add("bar", box(60, 5, 5)), add("bar", box(4, 60, 3));
            return expect(ClashKind::crossing, 0, 6);
        case 11: // overlap with coplanar faces, where all pairs of triangles only touch
            add("wall", box(40, 5, 30)), add("wall", box(40, 5, 30), {70, 0, 0});
            return expect(ClashKind::crossing, 0, 10);
        case 12: // the same part twice at the same pose
            add("twin", meshes_made_[0]), add("twin", meshes_made_[0]);
            return expect(ClashKind::duplicate);
        default: // one AABB contains the other, but the parts are apart: a ball in a ring
            add("ring", make_torus_mesh(60, 15, 2000)), add("ball", make_sphere_mesh(20, 500));
            return;
        }
    }

    const PlantedOptions& options_;
    std::vector<Mesh> meshes_;
    const std::vector<Mesh> meshes_made_{fitted(make_gear_mesh(12, 0.8, 1, 0.5, 0.3))};
    std::size_t side_, place_ = 0, used_ = 0, planted_ = 0;
    Vector3d middle_ = Vector3d::Zero();
    PlantedAssembly made_;
};

} // namespace

PlantedAssembly make_planted_assembly(const PlantedOptions& options)
{
    return Planter(options).run();
}

std::vector<std::string> faults_of(const PlantedAssembly& planted, const PartList& list,
                                   const std::vector<Clash>& found)
{
    std::vector<std::string> faults;
    std::map<std::pair<std::string, std::string>, const PlantedAssembly::Pair*> open;
    for (const auto& pair : planted.pairs) open[std::minmax(pair.a, pair.b)] = &pair;
    for (const Clash& c : found) {
        const std::string &a = list.parts[c.a].name, &b = list.parts[c.b].name;
        const auto place = open.find(std::minmax(a, b));
        const auto fault = [&](const std::string& what) { faults.push_back(fmt::format("{} and {}: {}", a, b, what)); };
        if (place == open.end()) {
            fault(fmt::format("{}, but was not planted", name_of(c.kind)));
            continue;
        }
        const PlantedAssembly::Pair& pair = *place->second;
        open.erase(place);
        if (c.kind != pair.kind) fault(fmt::format("{}, but planted as {}", name_of(c.kind), name_of(pair.kind)));
        constexpr double off = 1e-9; // mm, rounding
        if (pair.depth >= 0 && (c.reach.depth > pair.depth + off || 1.01 * c.reach.depth < pair.depth - off))
            fault(fmt::format("depth {}, but planted {}", c.reach.depth, pair.depth));
        if (pair.depth > 0 && std::isfinite(c.reach.thickness) && c.reach.thickness > pair.depth + off)
            fault(fmt::format("thickness {}, but planted with depth {}", c.reach.thickness, pair.depth));
        if (pair.thickness >= 0 && std::abs(c.reach.thickness - pair.thickness) > off)
            fault(fmt::format("thickness {}, but planted {}", c.reach.thickness, pair.thickness));
        if (pair.gap >= 0 && (c.lower > pair.gap + off || c.upper < pair.gap - off || c.upper - c.lower > 1e-6))
            fault(fmt::format("{} to {} apart, but planted {}", c.lower, c.upper, pair.gap));
    }
    for (const auto& [names, pair] : open)
        faults.push_back(fmt::format("{} and {}: planted as {}, but not found", pair->a, pair->b, name_of(pair->kind)));
    return faults;
}

} // namespace oncollide::tools
