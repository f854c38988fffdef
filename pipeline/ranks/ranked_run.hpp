#pragma once
#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include <oncollide/pipeline/ranks/rank_world.hpp>
#include <oncollide/pipeline/ranks/scene_slice.hpp>
#include <oncollide/pipeline/ranks/shared_file.hpp>

namespace oncollide {

/// When the regions are cut anew. Automatic: where one rank has had over a fifth more work than the mean for three
/// frames, or in the first one, and the frames that are left pay for it. Never changes the result.
enum class Rebalance : std::uint8_t { automatic, always, never };
Rebalance rebalance_from_name(std::string_view name); ///< throws Error{usage} that lists the valid names

struct RankedOptions {
    Rebalance rebalance = Rebalance::automatic;
    std::filesystem::path csv{};        ///< where rows go; empty: nowhere
    bool separate = false;              ///< rows of separate pairs, too
    bool trace = false;                 ///< keep the times of phases
    std::filesystem::path checkpoint{}; ///< written as FILE.0 and FILE.1 in turn; empty: none
    int checkpoint_every = 100;         ///< frames
    bool resume = false;                ///< go on from the last checkpoint
};

/// What one rank did, over all frames but where a maximum is meant.
struct RankStatistics {
    std::uint64_t frames = 0;
    std::uint64_t bodies = 0, ghosts = 0, pairs = 0; ///< at home; known besides; decided here
    std::uint64_t work = 0;                          ///< counted: 4 a body, 1 a pair, 1 for 8 pairs of cells or boxes
    std::uint64_t sent_bytes = 0, came = 0;          ///< to other ranks; bodies whose home this rank became
    std::uint64_t ghost_bytes = 0, row_bytes = 0;    ///< of those sent: ghosts, results
    std::uint64_t most_bodies = 0;                   ///< at home in one frame
    double step_ms = 0, move_ms = 0;                 ///< of the World; of moving and packing
    double wait_ms = 0;                              ///< exchanging and waiting for other ranks
    std::uint64_t peak_memory = 0;                   ///< bytes of the process, filled in by who can know it
};

/// A phase of a frame on one rank, microseconds since the run began.
struct RankPhase {
    enum Kind : std::uint32_t { move, exchange, step, results } kind;
    std::uint32_t frame;
    double begin_us, end_us;
};

/// Plays a scene on several ranks: the same pairs, verdicts, bounds, rows and hash as Pipeline, whatever the number of
/// ranks, the partition and the rebalancing.
///
/// Every rank has bodies at home, those whose boxes' centres are in its region, and knows the ghosts: bodies of other
/// ranks whose boxes touch its region. In a frame it moves those at home, hands over those that left, shows ranks what
/// reaches into their regions, and steps its RankWorld. Results go to ranks by the index of their first body, so that
/// rank after rank they are in order.
class RankedRun {
public:
    /// Keeps a reference to `ranks`. A call of all ranks; throws on all or on none, as every function here.
    /// Error{bad_data} for slices of different scenes and for names that two bodies have, Error{no_input} or
    /// Error{bad_data} for a checkpoint that cannot be used.
    RankedRun(Ranks& ranks, std::unique_ptr<Partitioner> partition, SceneSlice scene, const Settings& settings,
              const RankedOptions& options = {});
    ~RankedRun();

    int frame() const { return frame_; } ///< the next one
    void step();
    /// Writes out what is left and renames the files.
    void finish();

    /// As Pipeline::hash(). A call of all ranks.
    std::uint64_t hash();
    /// Pairs by verdict and by kind of contact, over all frames and ranks. Calls of all ranks.
    std::array<std::uint64_t, 4> verdicts();
    std::array<std::uint64_t, 5> kinds();
    /// By rank; on rank 0 only. A call of all ranks.
    std::vector<RankStatistics> statistics(std::uint64_t peak_memory);
    std::vector<std::vector<RankPhase>> phases();
    /// Sums over all ranks, ghosts included; times are the longest of any rank. A call of all ranks.
    std::vector<StageStats> totals();

    World& world() { return world_.world(); }
    std::string_view partitioner() const { return partition_->name(); }
    std::uint32_t bodies() const { return scene_.bodies; }
    int rebuilds() const { return rebuilds_; }

private:
    /// A pair on its way to the results: bodies by index.
    struct Row {
        PairResult pair;
        std::string text;
    };
    using Clock = std::chrono::steady_clock;

    void compare_slices();
    void refuse_names_twice();
    void move();
    void read_recording();
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
    std::uint64_t checksum_ = 0; ///< of the whole scene, for any number of ranks
    std::vector<Bytes> out_, in_;

    int frame_ = 0, moved_to_ = 0;
    bool partitioned_ = false, repartition_now_ = false;
    int uneven_frames_ = 0, rebuilds_ = 0;
    std::vector<Row> rows_;                            ///< of this frame, by this rank's share of first bodies
    std::uint64_t hash_ = 0;                           ///< of all frames so far; on the last rank
    std::uint64_t last_work_ = 0, last_pair_work_ = 0; ///< of the last frame; what pairs were of it
    std::array<std::uint64_t, 4> verdicts_{};
    std::array<std::uint64_t, 5> kinds_{};
    RankStatistics statistics_;
    std::vector<RankPhase> phases_;
    Clock::time_point began_, phase_began_;
    std::optional<SharedFile> csv_;
    std::uint64_t csv_end_ = 0; ///< where the next frame's rows begin
    int slot_ = 0;              ///< of the next checkpoint
    bool finished_ = false;
};

} // namespace oncollide
