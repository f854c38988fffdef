#pragma once
#include <oncollide/pipeline/settings.hpp>

namespace oncollide::tools {

/// Some drivers crash if memory is short, and a GPU backend runs in this process. Where memory is limited, by ulimit
/// -v, this function tries the backend of `settings` on a small scene in a process of its own. If the trial fails,
/// `auto` and `gl` become `cpu`, with a note, and another backend by name throws Error{no_gpu}. Otherwise the settings
/// stay as they are.
Settings with_tried_backend(Settings settings);

} // namespace oncollide::tools
