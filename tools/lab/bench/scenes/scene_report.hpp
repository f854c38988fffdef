#pragma once
#include <span>

#include "bench/scenes/scene_race.hpp"

namespace oncollide::tools {

/// The results of a race on a scene, as text and CSV. All arguments must outlive it.
class SceneReport {
public:
    SceneReport(const CompareOptions& options, const Settings& settings, const Scene& scene, const SceneRuns& runs)
        : options_(options), settings_(settings), scene_(scene), runs_(runs), with_fcl_(options.only != "oncollide"),
          with_ours_(options.only != "fcl")
    {
    }

    /// Returns the number of collisions that oncollide missed or reported wrongly.
    std::uint64_t print() const;
    void write_csv() const;
    void write_summary() const;

private:
    void print_head() const;
    void print_times() const;
    std::uint64_t print_counts() const;
    std::uint64_t print_faults() const;
    void print_memory() const;
    void print_timeline() const;

    std::span<const SceneRow> counted() const; ///< rows after the warm-up
    struct InMeshes {
        std::size_t triangles = 0, bytes = 0;
    };
    InMeshes in_meshes() const;
    std::uint64_t triangles() const; ///< of all geometries, in memory or in files

    const CompareOptions& options_;
    const Settings& settings_;
    const Scene& scene_;
    const SceneRuns& runs_;
    const bool with_fcl_, with_ours_;
};

} // namespace oncollide::tools
