#include <oncollide/scenes/files/tables/body_table.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/file_bytes.hpp>
#include <oncollide/scenes/files/common/quaternion.hpp>
#include <oncollide/scenes/files/json/at_node.hpp>

namespace oncollide {

void BodyRows::expect(std::size_t rows)
{
    const std::size_t most = scene_.has_sink() ? most_passed_bodies : most_bodies;
    if (rows > most - std::min(most, scene_.size()))
        refuse(file_, fmt::format("{} bodies in addition to {}; a scene has at most {}", rows, scene_.size(), most));
    scene_.reserve(scene_.size() + rows);
}

std::size_t BodyRows::wanted(std::size_t most) const
{
    std::size_t rows = 0;
    while (rows < most && scene_.wants(scene_.size() + rows)) ++rows;
    return rows;
}

void BodyRows::add(const BodyRow& row, FunctionRef<std::string()> place)
{
    BodyInit body;
    body.name = row.name;
    body.geometry = row.geometry;
    body.pose.translation() = row.position;
    if (row.rotation != Eigen::Vector4d(0, 0, 0, 1))
        body.pose.linear() = quaternion_of(place, row.rotation, scene_.warnings()).normalized().toRotationMatrix();
    if (!row.velocity.isZero(0))
        body.motion = Drift{.velocity = row.velocity, .spin = Eigen::Vector3d::Zero(), .walls = {}};
    body.layer = row.layer, body.mask = row.mask, body.group = row.group, body.is_static = row.is_static;
    try {
        scene_.add_body(std::move(body));
    } catch (const Error& error) {
        refuse(place(), error.what());
    }
}

void read_body_table(SceneBuilder& scene, const Node& entry, const std::filesystem::path& folder)
{
    entry.only({"file", "path", "geometry"});
    const std::filesystem::path path = file_of(entry["file"], folder);
    std::optional<GeometryId> geometry;
    if (entry.has("geometry")) {
        geometry = scene.find_geometry(entry["geometry"].text());
        if (!geometry) entry["geometry"].fail(fmt::format("no geometry named '{}'", entry["geometry"].text()));
    }
    BodyRows rows(scene, path.string(), geometry);
    const std::string kind = path.extension().string();
    if (kind == ".csv") {
        if (entry.has("path")) entry["path"].fail("is for HDF5 files");
        return read_csv_bodies(rows, path);
    }
    if (kind != ".h5" && kind != ".hdf5")
        entry["file"].fail(fmt::format("unknown kind of table '{}'; known are .csv, .h5, .hdf5", kind));
    read_hdf5_bodies(rows, path, entry.has("path") ? std::string(entry["path"].text()) : "bodies");
}

} // namespace oncollide
