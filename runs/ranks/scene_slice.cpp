#include <oncollide/runs/ranks/scene_slice.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/files/checksum.hpp>
#include <oncollide/pipeline/result_hash.hpp>
#include <oncollide/runs/report_kept.hpp>
#include <oncollide/scenes/cooked/cooked_map.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/cooked/cooked_terrain.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

namespace {

constexpr std::uint32_t run_of_bodies = 1024;

std::uint64_t checksum_of(const void* data, std::size_t bytes)
{
    return checksum({static_cast<const char*>(data), bytes});
}
std::uint64_t checksum_of(const Bytes& bytes)
{
    return checksum_of(bytes.data(), bytes.size());
}

/// Covers all of a mesh; the name, box and heights or points of other geometries; the header of cooked files.
std::uint64_t checksum_of(const Geometry& geometry)
{
    std::uint64_t sum = checksum(geometry.name);
    Bytes bytes;
    put(bytes, geometry.data.index());
    put_box(bytes, bounds_of(geometry));
    if (const auto* map = std::get_if<OccupancyMap>(&geometry.data)) {
        put_box(bytes, map->bounds());
        if (const CookedMapChunks* chunks = cooked_chunks(*map)) put(bytes, chunks->cooked()->checksum());
    }
    const auto* terrain = std::get_if<Terrain>(&geometry.data);
    if (const CookedTerrainChunks* chunks = terrain ? cooked_chunks(*terrain) : nullptr)
        put(bytes, chunks->cooked()->checksum());
    else if (terrain)
        for (std::uint32_t row = 0; row < terrain->rows(); ++row)
            for (std::uint32_t column = 0; column < terrain->columns(); ++column)
                put(bytes, terrain->height(column, row));
    if (const auto* shape = std::get_if<Shape>(&geometry.data))
        if (const auto* hull = std::get_if<ConvexHull>(shape))
            for (const Eigen::Vector3d& point : hull->points) put_vector(bytes, point);
    mix(sum, checksum_of(bytes));
    if (const auto* mesh = std::get_if<Mesh>(&geometry.data)) {
        mix(sum, checksum_of(mesh->vertices.data(), mesh->vertices.size() * sizeof(mesh->vertices[0])));
        mix(sum, checksum_of(mesh->triangles.data(), mesh->triangles.size() * sizeof(mesh->triangles[0])));
    }
    if (const auto* cooked = std::get_if<std::shared_ptr<const CookedMesh>>(&geometry.data))
        mix(sum, (*cooked)->outline().header_checksum); // which covers all other checksums of the file
    return sum;
}

} // namespace

SliceReader::SliceReader(int rank, int size, bool names) : rank_(rank), size_(size), names_(names) {}

int SliceReader::reader(std::uint32_t body) const
{
    return int(body / run_of_bodies % std::uint32_t(size_));
}

bool SliceReader::wants(std::uint32_t body) const
{
    const int by = reader(body);
    return by == rank_ || by == (rank_ + 1) % size_ || body < run_of_bodies;
}

void SliceReader::take(std::uint32_t body, BodyInit init)
{
    BodyRecord record{{.gid = body,
                       .geometry = index(init.geometry),
                       .layer = init.layer,
                       .mask = init.mask,
                       .group = init.group,
                       .is_static = init.is_static,
                       .pose = init.pose},
                      init.pose,
                      std::move(init.motion)};
    bytes_.clear();
    put(bytes_, record), put_list(bytes_, init.name);
    const std::uint64_t sum = checksum_of(bytes_);
    const int by = reader(body);
    if (body < run_of_bodies) first_ += sum;
    if (size_ > 1 && by == (rank_ + 1) % size_) slice_.other += sum;
    if (by != rank_) return;
    slice_.own += sum;
    if (!init.name.empty()) {
        const std::uint64_t hash = checksum(init.name);
        slice_.names.push_back({hash, checksum(init.name + char(hash & 0x7f)), body});
    }
    if (names_) record.name = csv_field(init.name.empty() ? fmt::format("body {}", body) : init.name);
    slice_.records.push_back(std::move(record));
}

/// Stores the exclusions of each record.
void SliceReader::exclude(const std::vector<ExcludedPair>& pairs)
{
    std::vector<ExcludedPair> both;
    for (const ExcludedPair pair : pairs) both.push_back(pair), both.push_back({pair.b, pair.a});
    std::ranges::sort(both, {}, &ExcludedPair::a);
    for (BodyRecord& record : slice_.records)
        for (auto at = std::ranges::lower_bound(both, record.gid, {}, &ExcludedPair::a);
             at != both.end() && at->a == record.gid; ++at)
            record.excluded.push_back(at->b);
}

void SliceReader::start_as_recorded()
{
    Recording& recording = *slice_.recording;
    auto at = std::ranges::lower_bound(slice_.records, recording.first, {}, &BodyRecord::gid);
    recording.read(
        0,
        [&](std::uint32_t i, const Eigen::Isometry3d& pose) {
            mix(slice_.common, checksum_of(pose.data(), sizeof(double) * 16));
            if (at == slice_.records.end() || at->gid != recording.first + i) return;
            if (at->is_static || !std::holds_alternative<Still>(at->motion))
                throw Error(ErrorKind::bad_data, fmt::format("{}: moves body {}, which {}", recording.file, at->gid,
                                                             at->is_static ? "is static" : "has a motion of its own"));
            at->pose = at->start = pose;
            ++at;
        },
        [&](std::uint32_t i) { return fmt::format("body {}", recording.first + i); });
}

SceneSlice SliceReader::finish(const SceneInfo& scene)
{
    slice_.name = scene.name, slice_.frames = scene.frames, slice_.pace = scene.pace;
    slice_.bodies = static_cast<std::uint32_t>(scene.size()), slice_.geometries = scene.geometries;
    slice_.recording = scene.recording, slice_.warnings = scene.warnings;
    std::uint64_t& sum = slice_.common;
    sum = checksum(scene.name);
    mix(sum, scene.size()), mix(sum, first_), mix(sum, std::bit_cast<std::uint64_t>(scene.pace));
    for (const Geometry& geometry : scene.geometries) mix(sum, checksum_of(geometry));
    for (const ExcludedPair pair : scene.excluded) mix(sum, std::uint64_t{pair.a} << 32 | pair.b);
    exclude(scene.excluded);
    if (slice_.recording) start_as_recorded();
    return std::move(slice_);
}

SceneSlice slice_of(const Scene& scene, int rank, int size, bool names)
{
    SliceReader reader(rank, size, names);
    pass_bodies(scene, reader);
    return reader.finish(scene);
}

} // namespace oncollide
