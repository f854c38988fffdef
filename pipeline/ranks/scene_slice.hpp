#pragma once
#include <string>
#include <vector>

#include <oncollide/pipeline/ranks/body_record.hpp>
#include <oncollide/scenes/scene.hpp>

namespace oncollide {

/// What is left of a body's name to find one that is there twice.
struct NameMark {
    std::uint64_t hash, other_hash;
    std::uint32_t gid;
};

/// A scene of which this rank has some of the bodies.
struct SceneSlice {
    std::string name;
    int frames = 1;
    double pace = 1;
    std::uint32_t bodies = 0; ///< of the whole scene
    GeometryList geometries;
    std::shared_ptr<Recording> recording;
    std::vector<BodyRecord> records; ///< of this rank, by index
    std::vector<NameMark> names;     ///< of those that have one
    std::vector<std::string> warnings;

    // Checksums, by which ranks find out whether they have read the same.
    std::uint64_t common = 0; ///< of what all read: name, pace, geometries, first bodies, exclusions, recorded starts
    std::uint64_t own = 0, other = 0; ///< sums over this rank's bodies, and over those of the rank after it
};

/// Takes one rank's bodies of a scene while it is read or made. Bodies are dealt out in short runs, so that how many
/// there are need not be known. The first ones and those of the next rank are looked at, too, and not kept: so what a
/// rank has of the scene was seen alike by another one.
class SliceReader final : public BodySink {
public:
    /// @param names  keep what bodies are called
    SliceReader(int rank, int size, bool names);

    bool wants(std::uint32_t body) const override;
    void take(std::uint32_t body, BodyInit init) override;
    /// The slice, once `scene` has passed all its bodies here. Throws Error{bad_data} for a recording that moves bodies
    /// which are static or have a motion.
    SceneSlice finish(const Scene& scene);

private:
    int reader(std::uint32_t body) const;
    void exclude(const std::vector<ExcludedPair>& pairs);
    void start_as_recorded();

    int rank_, size_;
    bool names_;
    SceneSlice slice_;
    std::uint64_t first_ = 0; ///< sum over the first bodies
    Bytes bytes_;
};

/// The slice of a scene that this rank holds whole.
SceneSlice slice_of(const Scene& scene, int rank, int size, bool names);

} // namespace oncollide
