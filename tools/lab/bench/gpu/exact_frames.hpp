#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include <oncollide/scenes/scene.hpp>

#include "bench/common/result_table.hpp"

namespace oncollide::tools {

/// The GPU of a measurement, and a number of threads to compare with.
struct ExactContest {
    int gpu;
    std::string renderer; ///< GL_RENDERER, in every row
    int threads;
};

/// Adds rows for the exact frames of a scene: by one core, by `threads` cores and by the backend gl; each with the gaps
/// of earlier frames, and with every pair walked. Returns the number of hashes that differ from the first one.
/// @param every  plays every N-th frame
/// @param stop   true: the rest is left out
int exact_frames(const ExactContest& contest, const std::string& title, const Scene& scene, int every,
                 ResultTable& table, const std::function<bool()>& stop);

/// Adds rows for one call of decide() with columns of poses, for two meshes of 5,000 triangles. Returns the number of
/// verdicts that differ.
/// @param poses  of the second mesh: a third of the pairs meet
int exact_batches(const ExactContest& contest, std::size_t poses, ResultTable& table);

} // namespace oncollide::tools
