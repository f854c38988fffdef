#pragma once
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/pipeline/settings.hpp>

// The settings compared by 'accuracy', 'oncollide-lab hard' and tests.
namespace oncollide::tools {

/// A way to run the pipeline.
struct SettingVariant {
    std::string name;
    Settings settings;

    /// Applies changes of setting_changes() by their names, separated by ", ", which are added to the name. Throws
    /// Error{internal} for an unknown name.
    void change(std::string_view names);
};

/// Every combination of the exact levels and the bounding volumes; other settings as in `base`.
std::vector<SettingVariant> levels_and_volumes(std::span<const ExactLevel> levels, const Settings& base);

/// A change of settings.
struct SettingChange {
    std::string name; ///< its name in results
    std::function<void(Settings&)> apply;
};

/// All changes that variants are made of.
std::span<const SettingChange> setting_changes();
/// The changes to other algorithms, memory and threads. None may change a result hash.
std::span<const SettingChange> changes_of_method();
/// The changes that skip a stage, one for each stage. Results may only get wider.
std::span<const SettingChange> changes_without_stage();

} // namespace oncollide::tools
