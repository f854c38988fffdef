#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/scenes/files/json/json_node.hpp>
#include <oncollide/scenes/scene_builder.hpp>

namespace oncollide {

// Bodies as rows of a table, in a separate file that a scene file names. Private to scenes.

/// Most bodies of a scene in its scene file and tables together; a scene with a sink is limited by the range of body
/// numbers.
constexpr std::size_t most_bodies = 10'000'000, most_passed_bodies = 2'000'000'000;

/// One row. Members without a column in the table keep these defaults.
struct BodyRow {
    GeometryId geometry{};
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Eigen::Vector4d rotation = {0, 0, 0, 1};            ///< x, y, z, w
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero(); ///< metres per frame
    std::uint32_t layer = 1, mask = 0xffffffffu, group = 0;
    bool is_static = false;
    std::string_view name{};
};

/// Adds the rows of one table to a scene.
class BodyRows {
public:
    /// @param geometry  the geometry of all rows; empty: a column of the table
    BodyRows(SceneBuilder& scene, std::string file, std::optional<GeometryId> geometry)
        : scene_(scene), file_(std::move(file)), geometry_(geometry)
    {
    }

    const SceneBuilder& scene() const { return scene_; }
    const std::string& file() const { return file_; }
    const std::optional<GeometryId>& geometry() const { return geometry_; }
    /// Makes room; throws if there are too many.
    void expect(std::size_t rows);
    /// Skips the next row if the scene does not want it.
    bool skip() { return scene_.skip_body(); }
    /// The number of the next rows that the scene wants, at most `most`.
    std::size_t wanted(std::size_t most) const;
    /// @param place  returns the position of the row, for errors
    void add(const BodyRow& row, FunctionRef<std::string()> place);

private:
    SceneBuilder& scene_;
    std::string file_;
    std::optional<GeometryId> geometry_;
};

/// Adds the bodies of an entry of a scene file's "tables". Throws Error{no_input} or Error{bad_data}, which name the
/// file and the row, and Error{usage} for a kind of file that this build cannot read.
void read_body_table(SceneBuilder& scene, const Node& entry, const std::filesystem::path& folder);

// One function per format.
void read_csv_bodies(BodyRows& rows, const std::filesystem::path& path);
/// @param group  the HDF5 group that has a dataset for each column
void read_hdf5_bodies(BodyRows& rows, const std::filesystem::path& path, const std::string& group);

} // namespace oncollide
