#pragma once
#include <string>
#include <vector>

#include <oncollide/runs/ranks/body_record.hpp>
#include <oncollide/scenes/recording.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// A fingerprint of a body's name, to detect duplicates.
struct NameMark {
    std::uint64_t hash, other_hash;
    std::uint32_t gid;
};

/// A scene with only this rank's share of the bodies.
struct SceneSlice {
    std::string name;
    int frames = 1;
    double pace = 1;
    std::uint32_t bodies = 0; ///< number of the whole scene
    GeometryList geometries;
    std::shared_ptr<Recording> recording;
    std::vector<BodyRecord> records; ///< this rank's bodies, by index
    std::vector<NameMark> names;     ///< names of this rank's bodies that have one
    std::vector<std::string> warnings;

    // Checksums, to verify that all ranks have read the same scene.
    std::uint64_t common = 0; ///< data that all ranks read: name, pace, geometries, first bodies, exclusions, recorded
                              ///< starts
    std::uint64_t own = 0, other = 0; ///< sums over this rank's bodies, and over the next rank's
};

/// Selects one rank's bodies while a scene is read or generated. Bodies are distributed in short runs, so their number
/// need not be known. For verification, the reader also examines, but does not keep, the first bodies and the next
/// rank's bodies, so every body is seen by two ranks.
class SliceReader final : public BodySink {
public:
    /// @param names  keep the bodies' names
    SliceReader(int rank, int size, bool names);

    bool wants(std::uint32_t body) const override;
    void take(std::uint32_t body, BodyInit init) override;
    /// Call after `scene` has passed all bodies to take(). Throws Error{bad_data} for a recording that moves bodies
    /// that are static or have a motion.
    SceneSlice finish(const SceneInfo& scene);

private:
    int reader(std::uint32_t body) const;
    void exclude(const std::vector<ExcludedPair>& pairs);
    void start_as_recorded();

    int rank_, size_;
    bool names_;
    SceneSlice slice_;
    std::uint64_t first_ = 0; ///< checksum of the first bodies
    Bytes bytes_;
};

/// This rank's slice of a complete scene.
SceneSlice slice_of(const Scene& scene, int rank, int size, bool names);

} // namespace oncollide
