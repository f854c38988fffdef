#include "verify/cases/drawn_scene.hpp"

#include <random>

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <oncollide/base/error.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

#include "verify/cases/case_numbers.hpp"

namespace oncollide::tools {
namespace {

class Draw : public CaseNumbers {
public:
    explicit Draw(std::uint64_t seed)
        : CaseNumbers(seed), on_grid_(seed % 4 != 0), terrains_(seed % 7 == 3), kinds_(seed % 5 < 3 ? 11 : 8)
    {
    }

    double between(double least, double most) { return std::uniform_real_distribution<double>(least, most)(random_); }
    double length() { return on_grid_ ? 0.125 * number(1, 12) : between(0.1, 1.5); }
    double coordinate() { return on_grid_ ? 0.125 * number(-10, 10) : between(-1.3, 1.3); }
    Eigen::Vector3d lengths()
    {
        return by_axis([this] { return length(); });
    }
    Eigen::Vector3d point()
    {
        return by_axis([this] { return coordinate(); });
    }

    Eigen::Isometry3d pose()
    {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() = 2 * point();
        if (!on_grid_ && one_in(2))
            pose.linear() = Eigen::Quaterniond(between(-1, 1), between(-1, 1), between(-1, 1), between(0.01, 1))
                                .normalized()
                                .toRotationMatrix();
        else
            for (int turns = number(0, 5); turns > 0; --turns) pose.linear() = (quarter_turn() * pose.linear()).eval();
        return pose;
    }
    Motion motion()
    {
        if (one_in(3)) return Still{};
        const double speed = on_grid_ ? 0.0625 : 0.05;
        return Drift{.velocity = speed * point(), .spin = Eigen::Vector3d::Zero(), .walls = {}};
    }
    RigidMotion way()
    {
        const Eigen::Isometry3d from = pose();
        if (one_in(6)) return RigidMotion(from);
        std::vector<RigidMotion::Key> keys{{0, from}};
        const int inner = one_in(4) ? number(1, 3) : 0;
        for (int k = 1; k <= inner + 1; ++k) {
            Eigen::Isometry3d to = pose();
            if (one_in(2)) to.linear() = keys.back().pose.linear();
            if (one_in(8)) to.translation() *= 256;
            keys.push_back({k == inner + 1 ? 1 : 0.25 * k, to});
        }
        return RigidMotion(keys, one_in(3) ? MotionPath::screw : MotionPath::linear);
    }
    GeometryData geometry()
    {
        if (terrains_ && one_in(2)) return terrain();
        switch (number(0, kinds_)) {
        case 0:
            return Shape(Sphere{length()});
        case 1:
            return Shape(Box{lengths()});
        case 2:
            return Shape(Capsule{length(), one_in(5) ? 0 : length()});
        case 3:
            return Shape(Cylinder{length(), length()});
        case 4:
            return make_box_mesh(lengths());
        case 5:
            return triangles();
        case 6:
            return map();
        case 9:
            return Shape(Ellipsoid{lengths()});
        case 10:
            return Shape(Cone{length(), length()});
        case 11:
            return Shape(HalfSpace{});
        default:
            return hull();
        }
    }
    Settings settings()
    {
        Settings s;
        if (one_in(2))
            s.depth = number(1, 6);
        else if (one_in(2))
            s.max_error = one_in(2) ? 0.05 : 0.5;
        if (one_in(3)) s.clearance = length();
        s.exact = one_in(4) ? ExactLevel::off : one_in(3) ? ExactLevel::fcl : ExactLevel::predicates;
        s.mode = one_in(3) ? Mode::solid : Mode::surface, s.open_as_surface = s.mode == Mode::solid;
        if (s.exact == ExactLevel::predicates) {
            s.contact_kinds = one_in(3);
            s.ignore_touching = one_in(6) && s.mode == Mode::surface && s.clearance == 0;
        }
        s.bounding_volume = static_cast<BoundingVolume>(number(0, 2));
        s.broad_phase = static_cast<BroadPhaseKind>(number(0, 2));
        s.threads = number(1, 3);
        s.coherence = !one_in(4);
        s.age_limit = number(1, 3);
        if (one_in(8)) s.node_budget = std::size_t(number(1, 400));
        if (one_in(8)) s.memory_budget = std::size_t(number(1, 200'000));
        if (one_in(6)) s.skip = {one_in(2) ? StageId::refine : StageId::delimitation};
        return s;
    }

private:
    template <class Number>
    Eigen::Vector3d by_axis(Number number)
    {
        const double x = number(), y = number(), z = number();
        return {x, y, z};
    }
    Eigen::Matrix3d quarter_turn()
    {
        const int axis = number(0, 2), u = (axis + 1) % 3, v = (axis + 2) % 3;
        Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
        turn(axis, axis) = 1, turn(u, v) = -1, turn(v, u) = 1;
        return turn;
    }
    GeometryData triangles()
    {
        std::vector<Eigen::Vector3d> vertices;
        std::vector<Triangle> faces;
        for (auto k = static_cast<std::uint32_t>(number(1, 5)); k-- > 0;) {
            const auto first = static_cast<std::uint32_t>(vertices.size());
            for (int i = 0; i < 3; ++i) vertices.push_back(point());
            faces.push_back({first, first + 1, one_in(10) ? first : first + 2}); // some without area
        }
        return make_mesh("triangles", vertices, faces);
    }
    GeometryData terrain()
    {
        TerrainGrid grid{.columns = static_cast<std::uint32_t>(number(2, 5)),
                         .rows = static_cast<std::uint32_t>(number(2, 4))};
        grid.spacing = {length(), length()}, grid.origin = point(), grid.no_data = -9;
        std::vector<double> heights;
        for (std::uint32_t i = 0; i < grid.columns * grid.rows; ++i)
            heights.push_back(i > 0 && one_in(12) ? -9 : coordinate());
        const auto whole = [](double height) { return height == -9 ? 0.25 : height; };
        heights[1] = whole(heights[1]); // at least one cell
        for (const std::uint32_t i : {grid.columns, grid.columns + 1}) heights[i] = whole(heights[i]);
        for (std::uint32_t i = 0; i < (grid.columns - 1) * (grid.rows - 1); ++i) grid.falling.push_back(one_in(2));
        return make_terrain("terrain", grid, heights);
    }
    GeometryData map()
    {
        octomap::OcTree tree(on_grid_ ? 0.25 : 0.3);
        const auto occupy = [&](const Eigen::Vector3d& p) {
            tree.updateNode(octomap::point3d(float(p.x()), float(p.y()), float(p.z())), true);
        };
        for (int k = number(1, 12); k > 0; --k) occupy(point());
        if (one_in(4)) // cells that the octree merges into a larger one
            for (int k = 0; k < 8; ++k) occupy({k & 1 ? 0.1 : 0.4, k & 2 ? 0.1 : 0.4, k & 4 ? 0.1 : 0.4});
        if (one_in(2)) return changed(make_occupancy_map(tree, one_in(4)));
        return changed(boxes(on_grid_ ? 0.0625 : 0.07));
    }
    /// Cells of many sizes: solid blocks with holes.
    OccupancyMap boxes(double resolution)
    {
        CellTree cells;
        const auto cell = [&] { return number(-20, 20); };
        const auto block = [&](CellState state) {
            const Eigen::Vector3i low(cell(), cell(), cell());
            cells.set({low, low + Eigen::Vector3i(number(1, 16), number(1, 16), number(1, 16))}, state);
        };
        for (int k = number(1, 3); k > 0; --k) block(CellState::occupied);
        for (int k = number(0, 3); k > 0; --k) block(one_in(2) ? CellState::free : CellState::unknown);
        cells.set({{3, 3, 3}, {4, 4, 4}}, CellState::occupied);
        return MapAccess::make("map", std::move(cells), resolution);
    }
    OccupancyMap changed(OccupancyMap map)
    {
        for (int k = number(0, 3); k > 0; --k) {
            const auto state = static_cast<CellState>(number(0, 2));
            const Eigen::Vector3d a = point(), b = point();
            try {
                if (one_in(2))
                    map.set(std::vector<Eigen::Vector3d>{a, b}, state);
                else
                    map.set(Aabb{a.cwiseMin(b), a.cwiseMax(b)}, state);
            } catch (const Error&) { // no cell would be left
            }
        }
        return map;
    }
    GeometryData hull()
    {
        while (true) {
            ConvexHull hull;
            if (one_in(3)) {
                const Eigen::Vector3d half = lengths();
                for (int k = 0; k < 8; ++k)
                    hull.points.push_back(
                        half.cwiseProduct(Eigen::Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1)));
            }
            for (int k = number(4, 12); k > 0; --k) hull.points.push_back(point());
            try {
                check_shape("hull", hull);
                return Shape(hull);
            } catch (const Error&) { // flat: draw again
            }
        }
    }

    bool on_grid_, terrains_;
    int kinds_; ///< number of kinds of geometry; tests use seeds from when there were fewer
};

} // namespace

DrawnScene draw_scene(std::uint64_t seed)
{
    Draw draw(seed);
    DrawnScene drawn;
    drawn.scene.name = fmt::format("drawn {}", seed), drawn.scene.frames = 3;
    for (int k = 0, bodies = draw.one_in(3) ? draw.number(3, 4) : 2; k < bodies; ++k) {
        const GeometryId geometry = drawn.scene.add(fmt::format("g{}", k), draw.geometry());
        const Eigen::Isometry3d pose = draw.pose();
        drawn.scene.add_body(
            {.name = fmt::format("b{}", k), .geometry = geometry, .pose = pose, .motion = draw.motion()});
    }
    drawn.settings = draw.settings();
    return drawn;
}

DrawnSweep draw_sweep(std::uint64_t seed)
{
    Draw draw(seed);
    GeometryData a = draw.geometry(), b = draw.geometry();
    RigidMotion motion_a = draw.way(), motion_b = draw.way();
    Settings settings;
    if (draw.one_in(4)) settings.clearance = draw.length();
    if (draw.one_in(4)) settings.mode = Mode::solid, settings.open_as_surface = true;
    return {std::move(a), std::move(b), std::move(motion_a), std::move(motion_b), settings};
}

} // namespace oncollide::tools
