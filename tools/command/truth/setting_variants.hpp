#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <oncollide/pipeline/settings.hpp>

// The settings compared by 'accuracy', 'oncollide-lab hard' and the crowd trial.
namespace oncollide::tools {

/// A way to run the pipeline.
struct SettingVariant {
    std::string name;
    Settings settings;
};

/// Every combination of the exact levels and the bounding volumes; other settings as in `base`.
std::vector<SettingVariant> levels_and_volumes(std::span<const ExactLevel> levels, const Settings& base);

/// A change of settings.
struct SettingChange {
    std::string name; ///< its name in results
    std::function<void(Settings&)> apply;
};

/// Other algorithms, memory and threads: none may change a result hash.
std::vector<SettingChange> changes_of_method();

constexpr StageId all_stages[] = {StageId::bounds, StageId::delimitation, StageId::broad, StageId::refine,
                                  StageId::exact};
/// Skips the stage: results may only get wider.
SettingChange without_stage(StageId stage);

} // namespace oncollide::tools
