// RankedRun: checkpoints, written alternately to FILE.0 and FILE.1. A checkpoint is a header followed by the poses of
// all bodies by index, so any number of ranks can continue from it.
#include <array>
#include <cstdio>
#include <fstream>

#include <fmt/format.h>

#include <oncollide/runs/ranks/ranked_run.hpp>

namespace oncollide {

struct RankedRun::Checkpoint {
    std::array<char, 8> magic{'o', 'n', 'c', 'o', 'l', 'l', 'c', 'p'};
    std::uint32_t version = 2, bodies = 0;
    std::uint64_t scene = 0, settings = 0; ///< checksums
    std::uint64_t frame = 0;               ///< the next frame
    std::uint64_t hash = 0, csv_end = 0;
    std::array<std::uint64_t, 4> verdicts{};
    std::array<std::uint64_t, 5> kinds{};
    std::uint64_t poses = 0;  ///< sum of the hashes of all poses
    std::uint64_t header = 0; ///< hash of all members above

    std::uint64_t hash_of_header() const
    {
        std::array<std::uint64_t, sizeof(Checkpoint) / 8> words;
        std::memcpy(words.data(), this, sizeof(Checkpoint));
        std::uint64_t sum = 0;
        for (std::size_t k = 0; k + 1 < words.size(); ++k) mix(sum, words[k]);
        return sum;
    }
};

namespace {

using PoseWords = std::array<std::uint64_t, 12>; ///< bit patterns of the upper three rows
constexpr std::uint64_t poses_begin = 512;

PoseWords words_of(const Eigen::Isometry3d& pose)
{
    PoseWords words;
    for (int k = 0; k < 12; ++k) words[std::size_t(k)] = std::bit_cast<std::uint64_t>(pose.matrix()(k / 4, k % 4));
    return words;
}

std::uint64_t hash_of(std::uint32_t gid, const PoseWords& words)
{
    std::uint64_t hash = gid;
    for (const std::uint64_t word : words) mix(hash, word);
    return hash;
}

} // namespace

std::filesystem::path RankedRun::slot_path(int slot) const
{
    return fmt::format("{}.{}", options_.checkpoint.string(), slot);
}

/// Hash of the settings that affect results and rows.
std::uint64_t RankedRun::settings_hash()
{
    std::uint64_t hash = hash_of(world_.world().settings());
    mix(hash, options_.csv.empty()), mix(hash, options_.separate);
    if (options_.continuous) mix(hash, 1);
    return hash;
}

void RankedRun::write_checkpoint()
{
    Checkpoint header;
    static_assert(sizeof(Checkpoint) <= poses_begin && sizeof(Checkpoint) % 8 == 0);
    header.bodies = scene_.bodies, header.scene = checksum_, header.settings = settings_hash();
    header.frame = std::uint64_t(frame_), header.csv_end = csv_end_;
    header.hash = hash(), header.verdicts = verdicts(), header.kinds = kinds();

    // Each rank writes one run of consecutive bodies.
    for (Bytes& bytes : out_) bytes.clear();
    for (const BodyRecord& body : home_) {
        const PoseWords words = words_of(body.pose);
        Bytes& to = out_[std::size_t(rank_of_row(body.gid))];
        put(to, body.gid), put(to, words);
        header.poses += hash_of(body.gid, words);
    }
    ranks_.sum({&header.poses, 1});
    header.header = header.hash_of_header();
    ranks_.exchange(out_, in_);
    std::uint32_t first = scene_.bodies;
    std::size_t count = 0;
    for (const Bytes& bytes : in_) {
        count += bytes.size() / (4 + sizeof(PoseWords));
        for (ByteReader reader(bytes); !reader.at_end(); reader.get<PoseWords>())
            first = std::min(first, reader.get<std::uint32_t>());
    }
    std::vector<PoseWords> run(count);
    for (const Bytes& bytes : in_)
        for (ByteReader reader(bytes); !reader.at_end();) {
            const auto gid = reader.get<std::uint32_t>();
            run.at(gid - first) = reader.get<PoseWords>();
        }

    SharedFile file(slot_path(slot_));
    together(ranks_, [&] {
        if (csv_) csv_->sync();
        if (ranks_.rank() == 0) file.create();
    });
    together(ranks_, [&] {
        file.open();
        if (ranks_.rank() == 0) file.write(0, {reinterpret_cast<const char*>(&header), sizeof(header)});
        file.write(poses_begin + std::uint64_t{first} * sizeof(PoseWords),
                   {reinterpret_cast<const char*>(run.data()), run.size() * sizeof(PoseWords)});
        file.sync();
    });
    together(ranks_, [&] {
        if (ranks_.rank() == 0) file.rename();
    });
    slot_ = 1 - slot_;
}

/// Reads the later of the two checkpoints that are complete.
void RankedRun::read_checkpoint()
{
    std::array<Checkpoint, 2> headers;
    std::array<bool, 2> good{};
    std::string why = fmt::format("{}: there is no checkpoint", slot_path(0).string());
    ErrorKind kind = ErrorKind::no_input;
    for (int slot = 0; slot < 2; ++slot) {
        Checkpoint& header = headers[std::size_t(slot)];
        std::ifstream file(slot_path(slot), std::ios::binary);
        if (!file) continue;
        const Checkpoint ours;
        const bool read = bool(file.read(reinterpret_cast<char*>(&header), sizeof(header)));
        kind = ErrorKind::bad_data;
        const auto refuse = [&](const char* what) { why = fmt::format("{}: {}", slot_path(slot).string(), what); };
        if (!read || header.magic != ours.magic)
            refuse("is not a checkpoint, or is damaged");
        else if (header.version != ours.version)
            refuse("is a checkpoint of another version of oncollide");
        else if (header.header != header.hash_of_header())
            refuse("is not a checkpoint, or is damaged");
        else if (header.scene != checksum_ || header.bodies != scene_.bodies)
            refuse("is a checkpoint of another scene");
        else if (header.settings != settings_hash())
            refuse("is a checkpoint of a run with other settings or outputs");
        else
            good[std::size_t(slot)] = true;
    }
    // Use a checkpoint only if all ranks find it good.
    std::array<std::uint64_t, 2> votes{good[0], good[1]};
    ranks_.sum(votes);
    const int later = headers[1].frame > headers[0].frame;
    for (const int slot : {later, 1 - later}) {
        const Checkpoint& header = headers[std::size_t(slot)];
        if (votes[std::size_t(slot)] != std::uint64_t(ranks_.size())) continue;
        if (!read_poses(slot, header)) {
            why = fmt::format("{}: is damaged", slot_path(slot).string());
            continue;
        }
        frame_ = int(header.frame), moved_to_ = frame_ - 1, csv_end_ = header.csv_end;
        slot_ = 1 - slot;
        if (ranks_.rank() + 1 == ranks_.size()) hash_ = header.hash;
        if (ranks_.rank() == 0) verdicts_ = header.verdicts, kinds_ = header.kinds;
        return;
    }
    together(ranks_, [&] { throw Error(kind, why); });
}

/// Reads this rank's bodies, in runs of consecutive indices. Changes nothing if the checksum over all ranks differs.
bool RankedRun::read_poses(int slot, const Checkpoint& header)
{
    std::vector<PoseWords> words(home_.size());
    std::uint64_t sum = 0;
    std::ifstream file(slot_path(slot), std::ios::binary);
    for (std::size_t begin = 0, end = 0; begin < home_.size(); begin = end) {
        for (end = begin + 1; end < home_.size() && home_[end].gid == home_[end - 1].gid + 1;) ++end;
        file.seekg(std::streamoff(poses_begin + std::uint64_t{home_[begin].gid} * sizeof(PoseWords)));
        file.read(reinterpret_cast<char*>(words.data() + begin), std::streamsize((end - begin) * sizeof(PoseWords)));
    }
    for (std::size_t i = 0; i < home_.size(); ++i) sum += hash_of(home_[i].gid, words[i]);
    ranks_.sum({&sum, 1});
    if (sum != header.poses) return false;
    for (std::size_t i = 0; i < home_.size(); ++i)
        for (int k = 0; k < 12; ++k)
            home_[i].pose.matrix()(k / 4, k % 4) = std::bit_cast<double>(words[i][std::size_t(k)]);
    return true;
}

} // namespace oncollide
