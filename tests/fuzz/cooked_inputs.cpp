#include "cooked_inputs.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <map>
#include <vector>

#include "cooked_bytes.hpp"
#include "formats.hpp"
#include "seeds.hpp"
#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/cooked/cooked_map.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/cooked/cooked_terrain.hpp>
#include <oncollide/scenes/geometry.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide::test {

namespace {

namespace fs = std::filesystem;

struct Field {
    std::size_t at, size;
};

/// All fields of a cooked file, by section, as far as the bytes go; and the ends of sections and chunks.
struct Layout {
    std::vector<std::vector<Field>> sections;
    std::vector<std::size_t> ends;

    explicit Layout(const std::string& bytes) : end_(bytes.size())
    {
        if (end_ < sizeof(CookedHeader)) return;
        const auto header = value_at<CookedHeader>(bytes, 0);
        add({{8, 4, 5}, {24, 8, 12}, {112, 4, 2}, {120, 8, 1}, {128, 4, 2}, {136, 8, 2}});
        const bool mesh = header.kind == CookedKind::mesh, terrain = header.kind == CookedKind::terrain;
        for (std::uint32_t i = 0; i < header.nodes && at_ < end_; ++i)
            if (mesh)
                add({{0, 2, 80}, {160, 4, 32}}, cooked_node_bytes(header.kind));
            else if (terrain)
                add({{0, 4, 6}}, sizeof(CookedRange));
            else
                add({{0, 4, 1}, {4, 1, 4}}, 8);
        const std::size_t table = at_;
        for (std::uint32_t i = 0; i < header.chunks && at_ < end_; ++i) add({{0, 8, 3}, {24, 4, 2}}, 32);
        for (std::uint64_t i = 0; i < header.parts && at_ < end_; ++i) add({{0, 8, 18}}, cooked_part_bytes);
        if (terrain) add({{0, 4, 2}, {8, 8, 5}, {48, 4, 4}, {64, 8, 5}, {104, 4, 2}}, sizeof(CookedTerrainRecord));
        if (!mesh && !terrain) add({{0, 8, 1}, {8, 4, 8}, {40, 1, 4}, {44, 4, 1}}, sizeof(CookedMapRecord));
        for (std::uint32_t i = 0; i < header.chunks && at_ < end_ && table + 32 * (i + 1) <= end_; ++i) {
            const auto chunk = value_at<CookedChunkEntry>(bytes, table + 32 * i);
            if (!mesh) {
                const std::size_t length = std::min<std::size_t>(chunk.bytes, end_);
                const std::size_t size = terrain ? std::clamp<std::size_t>(header.coordinate_bytes, 1, 8) : 1;
                add({{0, 4, terrain ? 4 : length / 4}, {0, size, length / size}}, length);
                continue;
            }
            const std::size_t coordinate = header.coordinate_bytes == 4 ? 4 : 8;
            const std::size_t vertices = std::min<std::size_t>(chunk.vertices, end_ / 16),
                              triangles = std::min<std::size_t>(chunk.triangles, end_ / 10);
            add({{0, coordinate, 3 * vertices}}, 3 * vertices * coordinate);
            add({{0, 4, vertices}}, 4 * vertices);
            add({{0, 2, 3 * triangles}}, 6 * triangles);
            add({{0, 4, triangles}}, (4 * triangles + 7) / 8 * 8);
        }
    }

private:
    struct Run {
        std::size_t from, size, count;
    };
    void add(std::initializer_list<Run> runs, std::size_t bytes = sizeof(CookedHeader))
    {
        std::vector<Field> fields;
        for (const Run& run : runs)
            for (std::size_t i = 0; i < run.count; ++i)
                if (const std::size_t at = at_ + run.from + i * run.size; at + run.size <= end_)
                    fields.push_back({at, run.size});
        if (!fields.empty()) sections.push_back(std::move(fields));
        at_ += bytes;
        ends.push_back(std::min(at_, end_));
    }
    std::size_t at_ = 0, end_;
};

/// A new value for a field of `size` bytes: a limit, a neighbouring value, a NaN, or any value.
std::uint64_t changed(std::uint64_t value, std::size_t size, std::mt19937_64& random)
{
    const std::uint64_t all = size == 8 ? ~std::uint64_t{0} : (std::uint64_t{1} << 8 * size) - 1;
    const auto real = [&](double number) {
        return size == 4 ? std::bit_cast<std::uint32_t>(float(number)) : std::bit_cast<std::uint64_t>(number);
    };
    const bool is_real = size >= 4 && random() % 2;
    switch (random() % 14) {
    case 0:
        return 0;
    case 1:
        return is_real ? real(std::numeric_limits<double>::quiet_NaN()) : all;
    case 2:
        return is_real ? real(std::numeric_limits<double>::infinity()) : all >> 1;
    case 3:
        return is_real ? real(-1e300) : value + 1;
    case 4:
        return is_real ? real(1e-40) : value - 1;
    case 5:
        return is_real ? real(std::ldexp(double(random() % 1000) - 500, -7)) : value * 2;
    case 6:
        return random();
    case 7:
        return random() % 16;
    case 8:
        return std::uint64_t{1} << random() % 64;
    case 9:
    case 10:
    case 11:
        return value + random() % 16 - 8;
    default:
        return value ^ std::uint64_t{1} << random() % (8 * size);
    }
}

/// The file opened as by a scene, and the whole contents in memory.
struct Opened {
    GeometryData data;
    std::uint64_t checksum = 0;

    explicit Opened(const fs::path& file)
    {
        switch (cooked_kind(file)) {
        case CookedKind::terrain: {
            auto terrain = std::make_shared<const CookedTerrain>(file);
            checksum = terrain->checksum(), data = CookedTerrainChunks::terrain(std::move(terrain));
            break;
        }
        case CookedKind::map: {
            auto map = std::make_shared<const CookedMap>(file);
            checksum = map->checksum(), data = CookedMapChunks::map(std::move(map));
            break;
        }
        default: {
            auto mesh = std::make_shared<const CookedMesh>(file);
            checksum = mesh->outline().header_checksum, data = std::move(mesh);
        }
        }
    }
    GeometryData whole() const
    {
        if (const auto* terrain = std::get_if<Terrain>(&data)) return in_memory(*terrain);
        if (const auto* map = std::get_if<OccupancyMap>(&data)) {
            const CellTree& all = MapAccess::cells(*map);
            CellTree cells(all.unknown_is_solid());
            all.each_leaf([&](const MapCell& cube, CellState state) { cells.set(CellBox(cube), state); });
            return MapAccess::make("map", std::move(cells), map->resolution());
        }
        return std::get<std::shared_ptr<const CookedMesh>>(data)->whole();
    }

private:
    static Terrain in_memory(const Terrain& terrain)
    {
        TerrainGrid grid{.columns = terrain.columns(),
                         .rows = terrain.rows(),
                         .spacing = terrain.spacing(),
                         .origin = terrain.origin(),
                         .bytes = 8,
                         .error = terrain.error()};
        if (terrain.holes()) grid.no_data = std::numeric_limits<double>::quiet_NaN();
        std::vector<double> heights;
        for (std::uint32_t row = 0; row < terrain.rows(); ++row)
            for (std::uint32_t column = 0; column < terrain.columns(); ++column)
                heights.push_back(terrain.height(column, row));
        for (std::uint32_t y = 0; y < terrain.cells_y(); ++y)
            for (std::uint32_t x = 0; x < terrain.cells_x(); ++x)
                grid.falling.push_back(terrain.diagonal(x, y) == CellDiagonal::falling);
        return make_terrain("terrain", grid, heights);
    }
};

/// The results of a World for a mesh, unrotated and rotated, with bodies inside, on and beside it.
struct Found {
    struct Pair {
        std::uint32_t a, b;
        Verdict verdict;
        double bound;
    };
    std::vector<Pair> pairs;
    std::vector<std::string> faults;
};

std::shared_ptr<const Geometry> named(GeometryData data)
{
    return std::make_shared<const Geometry>(Geometry{"queried", std::move(data), {}});
}

class Queries {
public:
    explicit Queries(const std::shared_ptr<const Geometry>& mesh)
    {
        const ModelId model = world_.models().add(mesh);
        Eigen::Isometry3d rotated = Eigen::Isometry3d::Identity();
        rotated.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
        rotated.translation() = Eigen::Vector3d(0.3, 0.1, 4.5);
        bodies_.push_back(world_.bodies().add({.model = model, .is_static = true}));
        bodies_.push_back(world_.bodies().add({.model = model, .pose = rotated}));
        static const auto crate = named(make_box_mesh({0.2, 0.3, 0.4}));
        const ModelId crates = world_.models().add(crate), ball = world_.models().add(Shape(Sphere{0.4}), "ball");
        for (const Eigen::Vector3d& at : {Eigen::Vector3d(0, 0, 0.3), {1, 0.5, 1}, {-0.8, 0.7, 4}, {0.1, 0.2, 2.2}})
            for (const ModelId of : {crates, ball})
                bodies_.push_back(
                    world_.bodies().add({.model = of, .pose = Eigen::Isometry3d(Eigen::Translation3d(at))}));
    }
    Found results()
    {
        Found found;
        for (const PairResult& pair : world_.step().pairs)
            if (std::min(pair.a.slot, pair.b.slot) < 2)
                found.pairs.push_back({pair.a.slot, pair.b.slot, pair.verdict, pair.bound});
        found.faults = world_.inspect().file_faults;
        return found;
    }
    double most_distance(const Found::Pair& pair)
    {
        return world_.pairs().distance(bodies_[pair.a], bodies_[pair.b]).upper;
    }

private:
    World world_{{.exact = ExactLevel::predicates}};
    std::vector<BodyId> bodies_;
};

bool same(const Found::Pair& a, const Found::Pair& b)
{
    return a.a == b.a && a.b == b.b && a.verdict == b.verdict && a.bound == b.bound;
}

/// Compares a damaged file with its seed. Unreadable parts may have wider boxes, which give more pairs.
void compare_damaged(const Found& seed, const Found& now)
{
    std::size_t next = 0;
    bool undecided = false;
    for (const Found::Pair& pair : now.pairs) {
        undecided |= pair.verdict == Verdict::undecided;
        const bool known = next < seed.pairs.size() && seed.pairs[next].a == pair.a && seed.pairs[next].b == pair.b;
        const Found::Pair* const of_seed = known ? &seed.pairs[next++] : nullptr;
        if (pair.verdict == Verdict::undecided) continue;
        if (of_seed ? !same(*of_seed, pair) : pair.verdict != Verdict::separate)
            fault("a damaged file has another result");
    }
    if (next < seed.pairs.size()) fault("a damaged file has lost a pair");
    if (undecided && now.faults.empty()) fault("undecided, and no fault says why");
}

/// Compares a valid file with its contents in memory. Its boxes may be different, so bounds may differ.
void compare_sealed(Queries& of_whole, const Found& whole, const Found& now)
{
    if (now.pairs.size() != whole.pairs.size()) fault("a cooked file has other pairs than its contents");
    for (std::size_t i = 0; i < now.pairs.size(); ++i) {
        const Found::Pair &a = whole.pairs[i], &b = now.pairs[i];
        if (a.a != b.a || a.b != b.b || a.verdict != b.verdict)
            fault("a cooked file has another result than its contents");
        if (a.bound != b.bound && !(b.bound <= of_whole.most_distance(b))) fault("a bound that is no bound");
    }
}

/// Keyed by the checksum of the header.
const std::map<std::uint64_t, Found>& seeds_results(const fs::path& folder)
{
    static const std::map<std::uint64_t, Found> results = [&] {
        std::map<std::uint64_t, Found> all;
        const fs::path file = folder / "seed.cooked";
        for (const std::string& seed : cooked_seeds()) {
            write_bytes(file, seed);
            const Opened opened(file);
            Found found = Queries(named(opened.data)).results(), whole = Queries(named(opened.whole())).results();
            if (!std::ranges::equal(found.pairs, whole.pairs, same) || found.pairs.size() < 3)
                fault("a seed's results differ from its contents' results");
            all.emplace(opened.checksum, std::move(found));
        }
        fs::remove(file);
        return all;
    }();
    return results;
}

} // namespace

std::string mutated_cooked(std::string bytes, std::mt19937_64& random)
{
    const auto pick = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    const std::size_t size = bytes.size();
    const Layout layout(bytes);
    if (layout.sections.empty()) return bytes;
    for (std::size_t changes = pick(2) ? 1 : 1 + pick(3); changes > 0; --changes) {
        const std::size_t what = pick(20);
        if (what == 0) { // a cut; the header may be adjusted to it
            const std::size_t end = layout.ends[pick(layout.ends.size())] + pick(3);
            bytes.resize(std::min(end > 0 ? end - 1 : 0, bytes.size()));
        } else if (what == 1) { // the same length, but some parts moved
            const std::size_t at = pick(bytes.size() + 1), to = pick(bytes.size() + 1);
            std::rotate(bytes.begin() + std::ptrdiff_t(std::min(at, to)),
                        bytes.begin() + std::ptrdiff_t(std::max(at, to)), bytes.end());
        } else if (what == 2) {
            bytes.insert(pick(bytes.size() + 1), 1 + pick(40), char(random()));
        } else {
            const auto& section = layout.sections[pick(layout.sections.size())];
            const Field field = section[pick(section.size())];
            if (field.at + field.size > bytes.size()) continue;
            std::uint64_t value = 0; // little-endian, like all supported machines
            std::memcpy(&value, bytes.data() + field.at, field.size);
            if (pick(8) == 0) { // the value of another field
                const Field other = section[pick(section.size())];
                std::memcpy(&value, bytes.data() + std::min(other.at, bytes.size() - field.size), field.size);
            } else {
                value = changed(value, field.size, random);
            }
            std::memcpy(bytes.data() + field.at, &value, field.size);
        }
        if (bytes.empty()) return bytes;
    }
    if (bytes.size() != size && bytes.size() >= sizeof(CookedHeader) && pick(2))
        set_value(bytes, offsetof(CookedHeader, file_bytes), bytes.size());
    return bytes;
}

void query_cooked(const fs::path& file, bool sealed)
{
    const auto& seeds = seeds_results(file.parent_path());
    const Opened opened(file);
    const Found found = Queries(named(opened.data)).results();
    for (const std::string& what : found.faults)
        if (what.find(file.string()) == what.npos) fault("a fault that does not name the file: " + what);
    if (!sealed) {
        const auto seed = seeds.find(opened.checksum);
        if (seed != seeds.end()) compare_damaged(seed->second, found);
        return;
    }
    check_cooked(file);
    if (!found.faults.empty()) fault("a sound file with a fault: " + found.faults[0]);
    Queries of_whole(named(opened.whole()));
    compare_sealed(of_whole, of_whole.results(), found);
}

} // namespace oncollide::test
