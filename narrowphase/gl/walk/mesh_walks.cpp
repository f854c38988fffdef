// A batch is one dispatch that places the pairs, and a fixed number of rounds of the walk; nothing is read back between
// them. A round without items ends at once.
#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <thread>

#include <fmt/format.h>

#include <oncollide/narrowphase/gl/batch_clock.hpp>
#include <oncollide/narrowphase/gl/context.hpp>
#include <oncollide/narrowphase/gl/list_store.hpp>
#include <oncollide/narrowphase/gl/walk/self_test.hpp>
#include <oncollide/narrowphase/gl/walk/tree_store.hpp>
#include <oncollide/narrowphase/gl/walk/walk_shaders.hpp>

namespace oncollide {

namespace {

using namespace gl;
using namespace gl::walk;

constexpr std::uint32_t wanted_room = 4096, first_unsure_room = 1 << 14;
/// The entries of each list that come back with the results; more take a second copy.
std::uint32_t read_at_once(std::size_t pairs)
{
    return 64 + static_cast<std::uint32_t>(pairs / 8);
}
/// Rows after which a walk leaves the rest of its stack to the next round, where a team takes each of its boxes. The
/// last round ends every walk, so it is short enough for a driver's watchdog.
constexpr std::array<GLuint, rounds> row_limits{48, 32, 32, 64, 64, 128, 256, 2048};

std::size_t allowed_bytes(const MeshWalkOptions& options)
{
    GLint64 block = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    const std::size_t most = std::min<std::size_t>(static_cast<std::size_t>(block), std::size_t{1} << 31);
    return options.most_buffer_bytes ? std::min(options.most_buffer_bytes, most) : most;
}

/// GPU times between the stages of a batch.
class StageClock {
public:
    StageClock() { glCreateQueries(GL_TIMESTAMP, GLsizei(queries_.size()), queries_.data()); }
    ~StageClock() { glDeleteQueries(GLsizei(queries_.size()), queries_.data()); }
    StageClock(const StageClock&) = delete;
    StageClock& operator=(const StageClock&) = delete;
    void mark(std::size_t i) { glQueryCounter(queries_[i], GL_TIMESTAMP); }
    /// Milliseconds from mark i to the next one.
    double ms(std::size_t i) const
    {
        GLuint64 from = 0, to = 0;
        glGetQueryObjectui64v(queries_[i], GL_QUERY_RESULT, &from);
        glGetQueryObjectui64v(queries_[i + 1], GL_QUERY_RESULT, &to);
        return double(to - from) * 1e-6;
    }

private:
    std::array<GLuint, 5> queries_;
};

std::string edited(const MeshWalkOptions& options, std::string source)
{
    return options.edit_shader ? options.edit_shader(std::move(source)) : source;
}

class GlMeshWalks final : public MeshWalks {
public:
    explicit GlMeshWalks(const MeshWalkOptions& options)
        : options_(options), context_((step(MeshWalkStep::context), options.gpu)), most_(allowed_bytes(options)),
          trees_(most_), prepare_((step(MeshWalkStep::shaders), "gl, prepare"),
                                  {{GL_COMPUTE_SHADER, edited(options, WalkShaders::prepare())}}),
          walk_("gl, walk", {{GL_COMPUTE_SHADER, edited(options, WalkShaders::walk())}}),
          item_room_(std::max<std::uint32_t>(options.first_items, 64))
    {
        GLint blocks = 0;
        glGetIntegerv(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS, &blocks);
        if (blocks < 8) throw GpuLost(fmt::format("gl: a shader may use {} buffers; the walk needs 8", blocks));
        context_.check("the making of gl");
    }
    ~GlMeshWalks() override
    {
        context_.use_at_end();
        if (fence_) glDeleteSync(fence_);
    }

    const GpuInfo& info() const override { return context_.info(); }
    bool is_owner() const override { return std::this_thread::get_id() == owner_; }
    std::optional<std::uint32_t> hold(const ObbTree& tree, std::uint32_t frame) override
    {
        context_.use();
        const auto slot = trees_.hold(tree, frame);
        counts_.trees_without_room = trees_.without_room();
        return slot;
    }
    void drop_unused(std::uint32_t frame) override
    {
        context_.use();
        trees_.drop_unused(frame);
    }

    void submit(std::span<const MeshWalkPose> poses, std::span<const MeshWalkPair> pairs, bool by_distance) override
    {
        context_.use();
        pairs_ = pairs.size(), results_.clear(), unsure_.clear(), wanted_.clear();
        if (pairs.empty()) return;
        clock_.mark(0);
        step(MeshWalkStep::trees);
        counts_.tree_bytes += trees_.upload();
        context_.check("the upload of trees");
        make_room();
        step(MeshWalkStep::upload);
        upload(poses, pairs);
        clock_.mark(1);
        step(MeshWalkStep::dispatch);
        dispatch(by_distance);
        queue_readback();
        counts_.batches += 1, counts_.pairs += pairs.size();
    }

    std::span<const MeshWalkResult> collect() override
    {
        if (pairs_ == 0) return {};
        context_.use();
        step(MeshWalkStep::readback);
        counts_.wait_ms += wait_for(fence_);
        context_.check("a batch of walks");
        std::array<std::uint32_t, header_words> head;
        std::memcpy(head.data(), readback_.data(), sizeof head);
        counts_.box_rows += head[header::box_rows], counts_.triangle_pairs += head[header::triangles];
        counts_.unsure_pairs += head[header::unsure];
        read_results();
        const std::uint32_t unsure = std::min(head[header::unsure], unsure_room_),
                            wanted = std::min(head[header::wanted], wanted_room);
        read_list(unsure, unsure_at(), first_of(unsure_room_), list_at(), [&](const std::uint32_t* w) {
            unsure_.push_back({w[0], w[1], w[2]});
        });
        read_list(wanted, wanted_at(), first_of(wanted_room), list_at() + unsure_words * first_of(unsure_room_),
                  [&](const std::uint32_t* w) {
                      wanted_.push_back({w[0], w[1], w[2]});
                  });
        counts_.upload_ms += clock_.ms(0), counts_.prepare_ms += clock_.ms(1), counts_.walk_ms += clock_.ms(2);
        counts_.readback_ms += clock_.ms(3);
        enlarge(head);
        return results_;
    }
    std::span<const UnsureTriangles> unsure() const override { return unsure_; }
    std::span<const WantedNode> wanted() const override { return wanted_; }
    const MeshWalkCounts& counts() const override { return counts_; }
    std::size_t bytes() const override
    {
        return trees_.bytes() + poses_.bytes() + pair_buffer_.bytes() + frames_.bytes() + items_.bytes() + out_.bytes();
    }

private:
    void step(MeshWalkStep which)
    {
        if (options_.before) options_.before(which);
    }
    std::uint32_t first_of(std::uint32_t room) const { return std::min(room, read_at_once(pairs_)); }
    std::size_t unsure_at() const { return header_words + result_words * pairs_; }
    std::size_t wanted_at() const { return unsure_at() + std::size_t{unsure_words} * unsure_room_; }
    std::size_t out_bytes() const { return 4 * (wanted_at() + wanted_words * wanted_room); }
    /// In the readback, where the first entries of the lists follow the results.
    std::size_t list_at() const { return unsure_at(); }
    std::size_t readback_bytes() const
    {
        return 4 * (list_at() + unsure_words * first_of(unsure_room_) + wanted_words * first_of(wanted_room));
    }

    void make_room()
    {
        grow(frames_, pairs_ * frame_bytes, 0, most_, "gl, frames");
        grow(items_, std::size_t{2} * 4 * item_words * item_room_, 0, most_, "gl, items");
        grow(out_, out_bytes(), 0, most_, "gl, results");
        readback_.make_room(readback_bytes(), "gl, results");
    }

    /// Poses, pairs and the header of the results, in one buffer.
    void upload(std::span<const MeshWalkPose> poses, std::span<const MeshWalkPair> pairs)
    {
        const std::size_t pose_bytes = poses.size_bytes(), pair_bytes = pairs.size() * sizeof(GpuPair),
                          head_bytes = 4 * header_words;
        grow(poses_, pose_bytes, 0, most_, "gl, poses"), grow(pair_buffer_, pair_bytes, 0, most_, "gl, pairs");
        upload_.make_room(pose_bytes + pair_bytes + head_bytes, "gl, poses");
        std::byte* to = upload_.data();
        std::memcpy(to, poses.data(), pose_bytes);
        auto* rows = reinterpret_cast<GpuPair*>(to + pose_bytes); // a pose is 96 bytes
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const MeshWalkPair& p = pairs[i];
            rows[i] = {p.pose_a, p.pose_b, p.tree_a, p.tree_b, p.hint_a, p.hint_b, p.enough, 0};
        }
        std::memset(to + pose_bytes + pair_bytes, 0, head_bytes);
        const auto copy = [&](const Buffer& target, std::size_t from, std::size_t bytes) {
            glCopyNamedBufferSubData(upload_.name(), target.name(), static_cast<GLintptr>(from), 0,
                                     static_cast<GLsizeiptr>(bytes));
        };
        copy(poses_, 0, pose_bytes), copy(pair_buffer_, pose_bytes, pair_bytes);
        copy(out_, pose_bytes + pair_bytes, head_bytes);
        counts_.bytes_up += pose_bytes + pair_bytes + head_bytes;
    }

    void dispatch(bool by_distance)
    {
        trees_.bind();
        const auto bind = [](unsigned where, const Buffer& buffer) {
            glBindBufferBase(GL_SHADER_STORAGE_BUFFER, where, buffer.name());
        };
        bind(slot::poses, poses_), bind(slot::pairs, pair_buffer_), bind(slot::frames, frames_);
        bind(slot::items, items_), bind(slot::out, out_);
        run(prepare_, 0, by_distance, static_cast<GLuint>((pairs_ + 63) / 64));
        clock_.mark(2);
        // Enough groups to fill a GPU; teams take items until there are none. llvmpipe ends a loop after some time, so
        // a group must not have too many items.
        const GLuint most = context_.info().software ? 1024 : 4096;
        const GLuint groups = std::clamp<GLuint>(static_cast<GLuint>((pairs_ + teams - 1) / teams), 64, most);
        for (GLuint round = 0; round < rounds; ++round) run(walk_, round, by_distance, groups);
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        clock_.mark(3);
        context_.check("the dispatch of walks");
    }

    void run(const Program& program, GLuint round, bool by_distance, GLuint groups)
    {
        glUseProgram(program.name());
        const auto set = [](GLint where, std::size_t value) { glUniform1ui(where, static_cast<GLuint>(value)); };
        set(0, pairs_), set(1, item_room_), set(2, unsure_room_), set(3, wanted_room);
        set(4, round), set(5, row_limits[round]), set(6, by_distance);
        glDispatchCompute(groups, 1, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        ++counts_.dispatches;
    }

    void queue_readback()
    {
        const auto copy = [&](std::size_t from, std::size_t to, std::size_t words) {
            glCopyNamedBufferSubData(out_.name(), readback_.name(), static_cast<GLintptr>(4 * from),
                                     static_cast<GLintptr>(4 * to), static_cast<GLsizeiptr>(4 * words));
        };
        const std::size_t unsure = unsure_words * first_of(unsure_room_);
        copy(0, 0, list_at() + unsure); // the list of unsure pairs follows the results
        copy(wanted_at(), list_at() + unsure, wanted_words * first_of(wanted_room));
        clock_.mark(4);
        glMemoryBarrier(GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
        if (fence_) glDeleteSync(fence_);
        fence_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
        glFlush();
        counts_.bytes_down += readback_bytes();
    }

    void read_results()
    {
        results_.resize(pairs_);
        const auto* words = reinterpret_cast<const std::uint32_t*>(readback_.data()) + header_words;
        for (std::size_t i = 0; i < pairs_; ++i, words += result_words) {
            MeshWalkResult& result = results_[i];
            std::memcpy(&result.bound, words + 1, sizeof result.bound);
            result.a = words[2], result.b = words[3];
            const bool ended = words[0] < state::item;
            result.verdict = words[0] & state::met              ? MeshWalkVerdict::meets
                             : words[0] & state::open || !ended ? MeshWalkVerdict::open
                             : words[0] & state::unsure         ? MeshWalkVerdict::unsure
                                                                : MeshWalkVerdict::apart;
        }
    }

    /// Calls take(words) for the entries of a list, of which the readback has the first `there`.
    template <class Take>
    void read_list(std::uint32_t count, std::size_t at, std::uint32_t there, std::size_t in_readback, Take take)
    {
        static_assert(unsure_words == wanted_words);
        const auto* words = reinterpret_cast<const std::uint32_t*>(readback_.data()) + in_readback;
        for (std::uint32_t i = 0; i < std::min(count, there); ++i) take(words + unsure_words * i);
        if (count <= there) return;
        rest_.resize(std::size_t{unsure_words} * (count - there));
        glGetNamedBufferSubData(out_.name(), static_cast<GLintptr>(4 * (at + std::size_t{unsure_words} * there)),
                                static_cast<GLsizeiptr>(4 * rest_.size()), rest_.data());
        context_.check("the reading of a list");
        counts_.bytes_down += 4 * rest_.size();
        for (std::size_t i = 0; i < rest_.size(); i += unsure_words) take(rest_.data() + i);
    }

    /// Makes room for the next batch if this one had too little.
    void enlarge(const std::array<std::uint32_t, header_words>& head)
    {
        const std::uint32_t items = *std::max_element(&head[header::queued], &head[header::queued] + rounds + 1);
        const bool full = items > item_room_ || head[header::unsure] > unsure_room_;
        counts_.full += full;
        const auto most = [&](std::size_t bytes) { return static_cast<std::uint32_t>(most_ / (2 * bytes)); };
        if (items > item_room_) item_room_ = std::min(2 * items, std::max(item_room_, most(2 * 4 * item_words)));
        if (head[header::unsure] > unsure_room_)
            unsure_room_ = std::min(2 * head[header::unsure], std::max(unsure_room_, most(4 * unsure_words)));
    }

    MeshWalkOptions options_;
    Context context_; // comes before all objects that live in it
    std::size_t most_;
    TreeStore trees_;
    Program prepare_, walk_;
    Buffer poses_, pair_buffer_, frames_, items_, out_;
    MappedBuffer upload_{GL_MAP_WRITE_BIT}, readback_{GL_MAP_READ_BIT};
    StageClock clock_;
    GLsync fence_ = nullptr;
    std::uint32_t item_room_, unsure_room_ = first_unsure_room;
    std::size_t pairs_ = 0;
    std::vector<MeshWalkResult> results_;
    std::vector<UnsureTriangles> unsure_;
    std::vector<WantedNode> wanted_;
    std::vector<std::uint32_t> rest_;
    MeshWalkCounts counts_;
    std::thread::id owner_ = std::this_thread::get_id();
};

} // namespace

std::unique_ptr<MeshWalks> make_mesh_walks(const MeshWalkOptions& options)
{
    auto walks = std::make_unique<GlMeshWalks>(options);
    if (options.before) options.before(MeshWalkStep::self_test);
    if (const std::string fault = fault_of(*walks); !fault.empty())
        throw GpuLost(fmt::format("{}: failed the self-test: {}", walks->info().renderer, fault));
    return walks;
}

} // namespace oncollide
