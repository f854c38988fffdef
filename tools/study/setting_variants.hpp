#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <oncollide/pipeline/settings.hpp>

// Which settings are compared with each other: the one list of 'accuracy', 'accuracy hard' and the crowd.
namespace oncollide::tools {

/// One way to run the pipeline.
struct SettingVariant {
    std::string name;
    Settings settings;
};

/// Each of the exact levels with each bounding volume, all else as in `base`.
std::vector<SettingVariant> levels_and_volumes(std::span<const ExactLevel> levels, const Settings& base);

/// One change of settings.
struct SettingChange {
    std::string name; ///< as results name it
    std::function<void(Settings&)> apply;
};

/// Other algorithms, memory and threads: none may change a result hash.
std::vector<SettingChange> changes_of_method();

constexpr const char* stage_names[] = {"bounds", "delimitation", "broad", "ocst", "exact"};
/// Leaves the stage out: results may only get wider.
SettingChange without_stage(const char* stage);

} // namespace oncollide::tools
