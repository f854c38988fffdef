#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

// Bodies as rows of a table, in a file of its own that a scene file names. Private to scenes.

/// A scene may have at most so many bodies, in its scene file and its tables together; one that passes them on, as many
/// as there are numbers for.
constexpr std::size_t most_bodies = 10'000'000, most_passed_bodies = 2'000'000'000;

/// One row. What a table has no column for stays as it is here.
struct BodyRow {
    GeometryId geometry{};
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector4d rotation = {0, 0, 0, 1};            ///< x, y, z, w
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero(); ///< metres per frame
    std::uint32_t layer = 1, mask = 0xffffffffu, group = 0;
    bool is_static = false;
    std::string_view name{};
};

/// Takes the rows of one table into a scene.
class BodyRows {
public:
    /// @param geometry  of all rows; none: the table says it
    BodyRows(Scene& scene, std::string file, std::optional<GeometryId> geometry)
        : scene_(scene), file_(std::move(file)), geometry_(geometry)
    {
    }

    const Scene& scene() const { return scene_; }
    const std::string& file() const { return file_; }
    const std::optional<GeometryId>& geometry() const { return geometry_; }
    /// Makes room; throws when that is too many.
    void expect(std::size_t rows);
    /// Passes over the next row where the scene does not want it.
    bool skip() { return scene_.skip_body(); }
    /// How many of the next rows, `most` at most, the scene wants, up to the first that it does not.
    std::size_t wanted(std::size_t most) const;
    /// @param place  where the row is, for errors
    void add(const BodyRow& row, FunctionRef<std::string()> place);

private:
    Scene& scene_;
    std::string file_;
    std::optional<GeometryId> geometry_;
};

/// Adds the bodies of an entry of a scene file's "tables". Throws Error{no_input} or Error{bad_data}, which name the
/// file and the row, Error{usage} for a kind of file that this build cannot read.
void read_body_table(Scene& scene, const Node& entry, const std::filesystem::path& folder);

// One function a format.
void read_csv_bodies(BodyRows& rows, const std::filesystem::path& path);
/// @param group  of HDF5, which holds a dataset for each column
void read_hdf5_bodies(BodyRows& rows, const std::filesystem::path& path, const std::string& group);

} // namespace oncollide
