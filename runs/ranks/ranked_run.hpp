#pragma once
#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include <oncollide/pipeline/result_hash.hpp>
#include <oncollide/runs/ranks/rank_world.hpp>
#include <oncollide/runs/ranks/scene_slice.hpp>
#include <oncollide/runs/ranks/shared_file.hpp>

namespace oncollide {

/// When the regions are divided anew. Automatic: if one rank has had over a fifth more work than the mean for three
/// frames (one frame after the first division) and the remaining frames repay the cost. Never changes the result.
enum class Rebalance : std::uint8_t { automatic, always, never };
Rebalance rebalance_from_name(std::string_view name); ///< throws Error{usage} listing the valid names

struct RankedOptions {
    Rebalance rebalance = Rebalance::automatic;
    std::filesystem::path csv{};        ///< output file for rows; empty: none
    bool separate = false;              ///< also write rows of separate pairs
    bool continuous = false;            ///< bodies move on the way from frame to frame, as with
                                        ///< Pipeline::set_continuous
    bool trace = false;                 ///< keep the times of phases
    std::filesystem::path checkpoint{}; ///< written alternately to FILE.0 and FILE.1; empty: none
    int checkpoint_every = 100;         ///< frames between checkpoints
    bool resume = false;                ///< continue from the last checkpoint
};

/// Statistics of one rank: sums over all frames unless they are maxima.
struct RankStatistics {
    std::uint64_t frames = 0;
    std::uint64_t bodies = 0, ghosts = 0, pairs = 0; ///< home bodies; ghosts; pairs decided here
    std::uint64_t work = 0;                          ///< units: 4 per body, 1 per pair, 1 per 8 pairs of cells or OBBs
    std::uint64_t sent_bytes = 0, came = 0;          ///< bytes sent to other ranks; bodies whose home moved to this
                                                     ///< rank
    std::uint64_t ghost_bytes = 0, row_bytes = 0;    ///< parts of sent_bytes: ghosts, results
    std::uint64_t most_bodies = 0;                   ///< largest number of home bodies in a frame
    double step_ms = 0, move_ms = 0;                 ///< time in World::step(); time for moving and packing
    double wait_ms = 0;                              ///< exchanging and waiting for other ranks
    std::uint64_t peak_memory = 0;                   ///< bytes of the process, set by the caller
};

/// A phase of a frame on one rank, in microseconds since the start of the run.
struct RankPhase {
    enum Kind : std::uint32_t { move, exchange, step, results } kind;
    std::uint32_t frame;
    double begin_us, end_us;
};

/// Plays a scene on several ranks. Pairs, verdicts, bounds, rows and hash equal Pipeline's, independent of the number
/// of ranks, the partition and the rebalancing.
///
/// The home bodies of a rank have the centres of their AABBs in its region. A rank also has ghosts: other ranks' bodies
/// whose AABBs touch its region. In a frame it moves its home bodies, hands over bodies that left its region, sends
/// ghosts to other ranks and steps its RankWorld. Results go to ranks by the index of their first body, so they are in
/// order across ranks.
class RankedRun {
public:
    /// Keeps a reference to `ranks`. Collective; like every function here, throws on all ranks or on none.
    /// Error{bad_data} for slices of different scenes and for duplicate names, Error{no_input} or Error{bad_data} for
    /// an unusable checkpoint.
    RankedRun(Ranks& ranks, std::unique_ptr<Partitioner> partition, SceneSlice scene, const Settings& settings,
              const RankedOptions& options = {});
    ~RankedRun();

    int frame() const { return frame_; } ///< the next frame
    void step();
    /// Writes the remaining rows and renames the files.
    void finish();

    /// As Pipeline::hash(). Collective.
    std::uint64_t hash();
    /// Pairs by verdict and by kind of contact, over all frames and ranks. Collective.
    std::array<std::uint64_t, 4> verdicts();
    std::array<std::uint64_t, 5> kinds();
    /// One element per rank; returned on rank 0 only. Collective.
    std::vector<RankStatistics> statistics(std::uint64_t peak_memory);
    std::vector<std::vector<RankPhase>> phases();
    /// Sums over all ranks, ghosts included; times are maxima over ranks. Collective.
    std::vector<StageStats> totals();

    World& world() { return world_.world(); }
    std::uint32_t bodies() const { return scene_.bodies; }
    int rebuilds() const { return rebuilds_; }

private:
    /// A result on its way to its rank, with bodies by index.
    struct Row {
        PairResult pair;
        std::optional<SweepTimes> times;
        std::string text;
    };
    using Clock = std::chrono::steady_clock;

    void compare_slices();
    void refuse_names_twice();
    void move();
    void read_recording();
    void move(BodyRecord& body, const Eigen::Isometry3d& to);
    void repartition();
    void send_home();
    void exchange();
    void step_world(std::vector<Bytes>& out);
    void take_rows(std::vector<Bytes>& in);
    void write_rows();
    void watch_balance();
    void open_csv();
    void end_phase(RankPhase::Kind kind, double& sum);
    int rank_of_row(std::uint32_t first) const
    {
        return int(std::uint64_t{first} * std::uint64_t(ranks_.size()) / scene_.bodies);
    }
    // ranked_checkpoint.cpp
    struct Checkpoint;
    void write_checkpoint();
    void read_checkpoint();
    bool read_poses(int slot, const Checkpoint& header);
    std::filesystem::path slot_path(int slot) const;
    std::uint64_t settings_hash();

    Ranks& ranks_;
    std::unique_ptr<Partitioner> partition_;
    SceneSlice scene_;
    RankedOptions options_;
    RankWorld world_;
    std::vector<BodyRecord>& home_; ///< scene_.records
    std::vector<BodyHere> ghosts_;
    std::uint64_t checksum_ = 0; ///< checksum of the whole scene, independent of the number of ranks
    std::vector<Bytes> out_, in_;

    int frame_ = 0, moved_to_ = 0;
    bool partitioned_ = false, repartition_now_ = false;
    int uneven_frames_ = 0, rebuilds_ = 0;
    std::vector<Row> rows_;                            ///< rows of this frame, with first bodies in this rank's share
    std::uint64_t hash_ = 0;                           ///< hash of all frames so far; valid on the last rank
    std::uint64_t last_work_ = 0, last_pair_work_ = 0; ///< work of the last frame: all work, and the part due to pairs
    std::array<std::uint64_t, 4> verdicts_{};
    std::array<std::uint64_t, 5> kinds_{};
    RankStatistics statistics_;
    std::vector<RankPhase> phases_;
    Clock::time_point began_, phase_began_;
    std::optional<SharedFile> csv_;
    std::uint64_t csv_end_ = 0; ///< offset of the next frame's rows
    int slot_ = 0;              ///< number of the next checkpoint, 0 or 1
    bool finished_ = false;
};

} // namespace oncollide
