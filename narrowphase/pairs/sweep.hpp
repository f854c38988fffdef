#pragma once
#include <optional>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/narrowphase/pairs/motion_window.hpp>
#include <oncollide/narrowphase/pairs/pair_task.hpp>

namespace oncollide {

class PairWorker;

/// When two bodies first meet in a window; times as in swept_motion.hpp. Directions are in the world frame, from the
/// task's a to b. Witnesses are left in a PairMemory.
using FindEntry = FunctionRef<PartsEntry(const MotionWindow&, PairMemory&)>;
/// The contact of two parts that a decision left in a PairMemory; nothing: it left none.
using FindContact = FunctionRef<std::optional<Contact>(const PairTask&, const PairMemory&)>;

/// Advances through the motion window by window. The next window begins at the bound that the last one gave; it is
/// smaller the nearer the contact is. The exact test decides at the poses of single times.
SweepResult sweep(PairWorker& worker, const SweepTask& task, FindEntry entry, FindContact contact);

} // namespace oncollide
