#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/runs/ranks/ranked_run.hpp>

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/runs/deforming_models.hpp>
#include <oncollide/runs/report_kept.hpp>
#include <oncollide/scenes/recording.hpp>

namespace oncollide {

namespace {

constexpr std::uint64_t work_of_a_body = 4; // relative to a candidate pair
enum class Sent : std::uint8_t { ghost, home };

std::size_t bytes_to_others(const std::vector<Bytes>& out, int rank)
{
    std::size_t bytes = 0;
    for (std::size_t to = 0; to < out.size(); ++to) bytes += int(to) == rank ? 0 : out[to].size();
    return bytes;
}

} // namespace

Rebalance rebalance_from_name(std::string_view name)
{
    if (name == "auto") return Rebalance::automatic;
    if (name == "always") return Rebalance::always;
    if (name == "never") return Rebalance::never;
    throw Error(ErrorKind::usage, fmt::format("rebalance: no '{}'; valid: auto, always, never", name));
}

RankedRun::RankedRun(Ranks& ranks, std::unique_ptr<Partitioner> partition, SceneSlice scene, const Settings& settings,
                     const RankedOptions& options)
    : ranks_(ranks), partition_(std::move(partition)), scene_(std::move(scene)), options_(options),
      world_(scene_.geometries, settings, *partition_, ranks.rank()), home_(scene_.records),
      out_(std::size_t(ranks.size())), in_(std::size_t(ranks.size()))
{
    WorldAccess::parts_by_poses(world_.world());
    together(ranks_, [&] {
        if (options_.continuous) check_rigid(scene_.geometries);
        if (options_.separate && settings.coherence && ranks_.size() > 1)
            throw Error(ErrorKind::usage, "--separate: the gaps of separate pairs may come from earlier frames, which "
                                          "other processes may have computed; add --no-coherence");
    });
    compare_slices();
    refuse_names_twice();
    if (options_.resume) read_checkpoint();
    open_csv();
    began_ = phase_began_ = Clock::now();
}

/// Each rank also has a checksum of the next rank's bodies.
void RankedRun::compare_slices()
{
    struct Sums {
        std::uint64_t common, other;
    };
    for (Bytes& bytes : out_) put(bytes, Sums{scene_.common, scene_.other});
    ranks_.exchange(out_, in_);
    bool same = true;
    for (const Bytes& bytes : in_) same &= ByteReader(bytes).get<Sums>().common == scene_.common;
    const auto before = std::size_t(ranks_.rank() + ranks_.size() - 1) % in_.size();
    if (in_.size() > 1) same &= ByteReader(in_[before]).get<Sums>().other == scene_.own;
    std::uint64_t differ = !same;
    ranks_.sum({&differ, 1});
    together(ranks_, [&] {
        if (differ)
            throw Error(ErrorKind::bad_data, "the processes have read different scenes; all need the same files");
    });
    std::uint64_t bodies = scene_.own;
    ranks_.sum({&bodies, 1});
    checksum_ = scene_.common;
    mix(checksum_, bodies);
}

/// Sends names to ranks by hash, so equal names meet on one rank.
void RankedRun::refuse_names_twice()
{
    for (Bytes& bytes : out_) bytes.clear();
    for (const NameMark& mark : scene_.names) put(out_[mark.hash % out_.size()], mark);
    scene_.names = {};
    ranks_.exchange(out_, in_);
    std::vector<NameMark> marks;
    for (const Bytes& bytes : in_)
        for (ByteReader reader(bytes); !reader.at_end();) marks.push_back(reader.get<NameMark>());
    const auto name = [](const NameMark& mark) { return std::pair(mark.hash, mark.other_hash); };
    std::ranges::sort(marks, {}, [&](const NameMark& mark) { return std::pair(name(mark), mark.gid); });
    const auto twice = std::ranges::adjacent_find(marks, {}, name);
    together(ranks_, [&] {
        if (twice != marks.end())
            throw Error(ErrorKind::bad_data, fmt::format("body {}: has the same name as body {}; names must differ",
                                                         twice[1].gid, twice->gid));
    });
}

RankedRun::~RankedRun()
{
    // Rows that a checkpoint relies on stay.
    if (csv_ && !finished_ && options_.checkpoint.empty() && ranks_.rank() == 0) csv_->remove();
}

void RankedRun::open_csv()
{
    if (options_.csv.empty()) return;
    csv_.emplace(options_.csv);
    const std::string first_line = csv_first_line(options_.continuous);
    together(ranks_, [&] {
        if (ranks_.rank() != 0) return;
        // A process killed after the final rename leaves FILE but no FILE.part.
        if (options_.resume) csv_->take_back(csv_end_, slot_path(1 - slot_));
        csv_->create();
    });
    together(ranks_, [&] {
        csv_->open();
        if (ranks_.rank() != 0) return;
        if (csv_end_ > csv_->size())
            throw Error(ErrorKind::bad_data,
                        fmt::format("{}.part: has {} bytes, but the checkpoint of frame {} needs {}: rows are "
                                    "lost; start again without --resume",
                                    options_.csv.string(), csv_->size(), frame_, csv_end_));
        csv_->truncate(csv_end_);
        if (csv_end_ == 0) csv_->write(0, first_line);
    });
    csv_end_ = std::max<std::uint64_t>(csv_end_, first_line.size());
}

void RankedRun::end_phase(RankPhase::Kind kind, double& sum)
{
    const auto now = Clock::now();
    const auto us = [&](Clock::time_point t) { return std::chrono::duration<double, std::micro>(t - began_).count(); };
    sum += 1e-3 * (us(now) - us(phase_began_));
    if (options_.trace) phases_.push_back({kind, std::uint32_t(frame_), us(phase_began_), us(now)});
    phase_began_ = now;
}

void RankedRun::step()
{
    phase_began_ = Clock::now();
    together(ranks_, [&] { move(); });
    if (!partitioned_ || repartition_now_) repartition();
    exchange();
    std::vector<Bytes> rows(out_.size()), came;
    together(ranks_, [&] { step_world(rows); });
    statistics_.row_bytes += bytes_to_others(rows, ranks_.rank());
    statistics_.sent_bytes += bytes_to_others(rows, ranks_.rank());
    ranks_.exchange(rows, came);
    together(ranks_, [&] { take_rows(came); });
    write_rows();
    watch_balance();
    end_phase(RankPhase::results, statistics_.wait_ms);
    ++frame_;
    if (!options_.checkpoint.empty() && frame_ % options_.checkpoint_every == 0 && frame_ < scene_.frames)
        write_checkpoint();
}

/// Poses are assigned in the order of the recording, so home bodies are sorted by index first.
void RankedRun::read_recording()
{
    const std::uint32_t first = scene_.recording->first;
    std::ranges::sort(home_, {}, &BodyRecord::gid);
    auto at = std::ranges::lower_bound(home_, first, {}, &BodyRecord::gid);
    scene_.recording->read(
        static_cast<std::uint64_t>(frame_ * scene_.pace),
        [&](std::uint32_t i, const Eigen::Isometry3d& pose) {
            if (at == home_.end() || at->gid != first + i) return;
            move(*at++, pose);
        },
        [&](std::uint32_t i) { return fmt::format("body {}", first + i); });
}

void RankedRun::move()
{
    scene_.geometries.deform(frame_ * scene_.pace);
    world_.renew_models();
    if (scene_.recording) read_recording();
    for (BodyRecord& body : home_) {
        if (scene_.recording && body.gid - scene_.recording->first < scene_.recording->bodies) continue;
        Eigen::Isometry3d pose = body.pose;
        if (!std::holds_alternative<Still>(body.motion))
            move_body(body.motion, body.start, scene_.pace, moved_to_, frame_, pose);
        move(body, pose);
    }
    moved_to_ = frame_;
}

void RankedRun::move(BodyRecord& body, const Eigen::Isometry3d& to)
{
    bool changes = body.box.empty() || !body.way.empty() || body.pose.matrix() != to.matrix() ||
                   scene_.geometries.deforms(body.geometry);
    if (options_.continuous && frame_ > 0)
        body.way = way_between(body.motion, moved_to_ * scene_.pace, frame_ * scene_.pace, body.pose, to);
    changes |= !body.way.empty();
    body.pose = to;
    if (changes) body.box = world_.box(body);
}

void RankedRun::repartition()
{
    std::vector<Eigen::Vector3d> centres;
    std::vector<float> weights;
    // Distributes this rank's work on pairs to its bodies by their number of pairs.
    std::uint64_t pairs = 0;
    for (const BodyRecord& body : home_) pairs += world_.pairs_of(body.gid);
    const float of_a_pair = pairs ? float(double(last_pair_work_) / double(pairs)) : 0;
    for (const BodyRecord& body : home_) {
        centres.push_back(body.box.centre());
        weights.push_back(float(work_of_a_body) + of_a_pair * float(world_.pairs_of(body.gid)));
    }
    partition_->rebuild(ranks_, centres, weights);
    partitioned_ = true, repartition_now_ = false, uneven_frames_ = 0;
    ++rebuilds_;
    send_home();
}

/// Sends bodies to their new home ranks, in batches: all at once would need three times the memory.
void RankedRun::send_home()
{
    constexpr std::size_t at_a_time = 5'000;
    const int me = ranks_.rank();
    std::size_t looked_at = 0, end = home_.size(); // [looked_at, end): unexamined; from end: received
    for (std::uint64_t left = 1; left;) {
        for (Bytes& bytes : out_) bytes.clear();
        for (std::size_t sent = 0; looked_at < end && sent < at_a_time;) {
            BodyRecord& body = home_[looked_at];
            const int home = partition_->owner(body.box.centre());
            if (home == me) {
                ++looked_at;
                continue;
            }
            put(out_[std::size_t(home)], body), ++sent;
            if (looked_at != --end) body = std::move(home_[end]);
            if (end + 1 != home_.size()) home_[end] = std::move(home_.back());
            home_.pop_back();
        }
        statistics_.sent_bytes += bytes_to_others(out_, me);
        ranks_.exchange(out_, in_);
        for (const Bytes& bytes : in_)
            for (ByteReader reader(bytes); !reader.at_end(); ++statistics_.came) home_.push_back(get_record(reader));
        left = looked_at < end;
        ranks_.sum({&left, 1});
    }
    for (Bytes& bytes : out_) bytes = {};
    for (Bytes& bytes : in_) bytes = {};
}

/// Hands over bodies that have left this rank's region, sends ghosts, and receives both.
void RankedRun::exchange()
{
    for (Bytes& bytes : out_) bytes.clear();
    const int me = ranks_.rank();
    std::vector<int> touched;
    ghosts_.clear();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < home_.size(); ++i) {
        BodyRecord& body = home_[i];
        const int home = partition_->owner(body.box.centre());
        partition_->ranks(body.box, touched);
        for (const int rank : touched) {
            if (rank == home) continue;
            if (rank == me) {
                ghosts_.push_back(body);
                continue;
            }
            Bytes& bytes = out_[std::size_t(rank)];
            const std::size_t before = bytes.size();
            put(bytes, Sent::ghost), put(bytes, static_cast<BodyHere&>(body));
            statistics_.ghost_bytes += bytes.size() - before;
        }
        if (home == me) {
            if (kept != i) home_[kept] = std::move(body);
            ++kept;
        } else {
            put(out_[std::size_t(home)], Sent::home), put(out_[std::size_t(home)], body);
        }
    }
    home_.resize(kept);
    statistics_.sent_bytes += bytes_to_others(out_, me);
    end_phase(RankPhase::move, statistics_.move_ms);
    ranks_.exchange(out_, in_);
    for (const Bytes& bytes : in_)
        for (ByteReader reader(bytes); !reader.at_end();)
            if (reader.get<Sent>() == Sent::home)
                home_.push_back(get_record(reader)), ++statistics_.came;
            else
                ghosts_.push_back(get_body(reader));
    end_phase(RankPhase::exchange, statistics_.wait_ms);
}

void RankedRun::step_world(std::vector<Bytes>& out)
{
    world_.begin();
    for (const BodyRecord& body : home_) world_.add(body);
    for (const BodyHere& body : ghosts_) world_.add(body);
    const FrameView view = world_.step();
    SweepOfPair sweep_of(view);
    for (const PairResult& pair : view.pairs) {
        ++verdicts_[std::size_t(pair.verdict)], ++kinds_[std::size_t(pair.kind)];
        if (pair.verdict == Verdict::separate && !(csv_ && options_.separate)) continue;
        PairResult named = pair;
        named.a = {world_.gid(pair.a)}, named.b = {world_.gid(pair.b)};
        Bytes& to = out[std::size_t(rank_of_row(named.a.slot))];
        put(to, named);
        const PairSweep* const sweep = sweep_of(std::size_t(&pair - view.pairs.data()));
        if (options_.continuous) put(to, sweep != nullptr);
        if (sweep) put(to, SweepTimes{sweep->clear_until, sweep->contact_by});
        if (!csv_) continue;
        TextInMemory text;
        CsvWriter csv(text);
        add_csv_cells(csv, std::uint64_t(frame_), world_.name(pair.a), world_.name(pair.b), pair, name_of(pair.stage),
                      world_.world().pairs().max_error(pair.a, pair.b));
        if (options_.continuous) add_csv_cells(csv, sweep);
        csv.end_row();
        put_list(to, text.text());
    }
    last_pair_work_ = view.pairs.size() + view.trees.node_pairs / 8;
    last_work_ = work_of_a_body * home_.size() + last_pair_work_;
    statistics_.frames += 1, statistics_.pairs += view.pairs.size(), statistics_.work += last_work_;
    statistics_.bodies += home_.size(), statistics_.ghosts += ghosts_.size();
    statistics_.most_bodies = std::max<std::uint64_t>(statistics_.most_bodies, home_.size());
    end_phase(RankPhase::step, statistics_.step_ms);
}

void RankedRun::take_rows(std::vector<Bytes>& in)
{
    rows_.clear();
    for (const Bytes& bytes : in)
        for (ByteReader reader(bytes); !reader.at_end();) {
            Row& row = rows_.emplace_back(Row{reader.get<PairResult>(), {}, {}});
            if (options_.continuous && reader.get<bool>()) row.times = reader.get<SweepTimes>();
            if (csv_) row.text = reader.get_list<std::string>();
        }
    const auto order = [](const Row& row) { return BodyPair{row.pair.a.slot, row.pair.b.slot}; };
    std::ranges::sort(rows_, {}, order);
    if (const auto twice = std::ranges::adjacent_find(rows_, {}, order); twice != rows_.end())
        throw Error(ErrorKind::internal, fmt::format("frame {}: bodies {} and {} were decided by two processes", frame_,
                                                     twice->pair.a.slot, twice->pair.b.slot));
}

/// The frame's hash passes from rank to rank, and each adds its rows. No rank waits for the last one.
void RankedRun::write_rows()
{
    std::uint64_t hash = ranks_.rank() == 0 ? 0 : ranks_.receive(ranks_.rank() - 1);
    const bool kinds = wants_kinds(world_.world().settings());
    std::string text;
    for (const Row& row : rows_) {
        mix(hash, row.pair, kinds);
        if (row.times) mix(hash, row.pair, *row.times);
        if (csv_) text += row.text;
    }
    if (ranks_.rank() + 1 < ranks_.size())
        ranks_.send(ranks_.rank() + 1, hash);
    else
        mix(hash_, hash);
    if (!csv_) return;
    const std::uint64_t begin = csv_end_ + ranks_.before(text.size());
    std::uint64_t all = text.size();
    ranks_.sum({&all, 1});
    together(ranks_, [&] { csv_->write(begin, text); });
    csv_end_ += all;
}

void RankedRun::watch_balance()
{
    if (ranks_.size() == 1 || options_.rebalance == Rebalance::never) return;
    if (options_.rebalance == Rebalance::always) {
        repartition_now_ = true;
        return;
    }
    double most = double(last_work_);
    std::uint64_t all = last_work_;
    ranks_.most({&most, 1}), ranks_.sum({&all, 1});
    const double mean = double(all) / ranks_.size();
    uneven_frames_ = most > 1.2 * mean ? uneven_frames_ + 1 : 0;
    // Cost estimate: dividing anew costs each rank about four scans of its bodies.
    const double cost = 4.0 * double(work_of_a_body) * scene_.bodies / ranks_.size();
    // The first division knows no pairs, so it may be replaced sooner.
    repartition_now_ =
        uneven_frames_ >= (rebuilds_ == 1 ? 1 : 3) && (most - mean) * (scene_.frames - frame_ - 1) > cost;
}

void RankedRun::finish()
{
    finished_ = true;
    if (!csv_) return;
    together(ranks_, [&] { csv_->sync(); });
    together(ranks_, [&] {
        if (ranks_.rank() == 0) csv_->rename();
    });
}

} // namespace oncollide
