#pragma once
#include <optional>
#include <string>
#include <vector>

#include <oncollide/base/spool.hpp>
#include <oncollide/pipeline/pair_list.hpp>
#include <oncollide/pipeline/report.hpp>
#include <oncollide/pipeline/stage_times.hpp>

namespace oncollide {

struct Report::Kept {
    /// Frames as text, and what bodies are called there: quoted once, not once per row.
    struct Part {
        Spool text;
        std::vector<std::string> names;
    };
    std::optional<Part> json, csv;
    std::optional<Spool> trace;
    double trace_us = 0; ///< where the next frame begins in the trace
    StageTimes stage_times;
    PairList colliding, unsure; ///< unsure: within or undecided
};

} // namespace oncollide
