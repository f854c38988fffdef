#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/arguments.hpp"
#include "cli/outputs.hpp"

#include <oncollide/pipeline/settings.hpp>
#include <oncollide/scenes/files/scene_file.hpp>
#include <oncollide/scenes/scene.hpp>

// Options that several subcommands share. One function per struct adds its options to a subcommand; the struct must
// live until the command has run.
namespace oncollide::tools {

/// Options that become Settings: one per row of the table of settings.
class SettingsOptions {
public:
    /// The option of a member of Settings; the form of its row selects the field. Fields without a value keep the
    /// default of Settings.
    struct Value {
        std::optional<int> whole;
        std::optional<double> number;
        std::string text;  ///< value of a name or an amount
        bool flag = false; ///< true: the opposite of the default
        std::vector<std::string> list;
    };
    SettingsOptions();
    Value& operator[](std::string_view member) { return values_[index(member)]; }
    const Value& operator[](std::string_view member) const { return values_[index(member)]; }
    std::span<const Value> values() const { return values_; } ///< by row

private:
    static std::size_t index(std::string_view member);

    std::vector<Value> values_;
};

/// Adds the options of the group "Accuracy".
void add_accuracy_options(Arguments command, SettingsOptions& options);
/// Adds the options of the group "Computation".
void add_pipeline_options(Arguments command, SettingsOptions& options);
/// Throws Error{usage} for a name or number out of range.
Settings settings_from(const SettingsOptions& options);

/// Options of the cache of cooked meshes.
struct CacheOptions {
    std::string folder, bytes = "4G";
};
void add_cache_options(Arguments command, CacheOptions& options);
/// How to read a scene's meshes, with the cache if it names one.
SceneReading reading_with(const CacheOptions& options);

/// A scene file, an assembly, or the name of a scene of the catalogue.
struct SceneOptions {
    std::string scene;
    std::optional<int> bodies, frames;
    std::optional<std::uint64_t> seed;
    std::string data;
    double pace = 1;
    int most_parts = int(AssemblyOptions{}.most_parts); ///< most parts of an assembly
    CacheOptions cache = {};
    bool on_demand = false; ///< leave meshes in cooked files on disk; for commands that need only results
};

void add_catalogue_options(Arguments command, SceneOptions& options); ///< bodies, frames, seed, data, max-parts
void add_pace_option(Arguments command, SceneOptions& options);       ///< used by commands that play the scene
/// Reads or makes the scene. Throws Error{no_input} for a missing file or data folder, Error{usage} for an unknown name
/// or an option that does not apply to a file.
Scene open_scene(const SceneOptions& options);
/// The same, but hands the bodies to `sink` as they are read or made.
SceneInfo open_scene(const SceneOptions& options, BodySink& sink);
/// Throws Error{usage} if a geometry deforms.
/// @param command  its name; it makes trees of each geometry once
void must_be_rigid(const Scene& scene, const char* command);
/// True if `text` names a file rather than a scene of the catalogue: it is "-" (standard input), contains a '/' or ends
/// in .json, or is an existing file and not a known name. Throws Error{usage} if it could be both.
bool is_scene_file(const std::string& text);

/// The data folder: `option` if given, else $ONCOLLIDE_DATA, else ../shared/data if it exists, else empty.
/// Throws Error{no_input} if `option` or $ONCOLLIDE_DATA is not a folder.
std::filesystem::path data_folder(const std::string& option);

/// Prints the first ten warnings of loading to standard error, one per line.
void print_warnings(const Scene& scene);

} // namespace oncollide::tools
