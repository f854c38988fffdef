// A batch is one dispatch that places the pairs, and a fixed number of rounds of the walk; nothing is read back between
// them. The shaders write how many work groups the next round needs.
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

/// Drivers without doubles may still compile shaders that use them.
void need_doubles(const MeshWalkOptions& options, const GpuInfo& info)
{
    constexpr const char* extension = "GL_ARB_gpu_shader_fp64";
    if (options.hidden_extension == extension || (epoxy_gl_version() < 40 && !epoxy_has_gl_extension(extension)))
        throw GpuLost(fmt::format("{}: no doubles in shaders ({})", info.renderer, extension));
}

/// A batch has these besides the buffers that all batches use one after the other.
struct Batch {
    MappedBuffer upload{GL_MAP_WRITE_BIT}; ///< the header of the results, then the pairs
    MappedBuffer readback{GL_MAP_READ_BIT};
    Buffer pairs, out;
    StageClock clock;
    GLsync fence = nullptr;
    std::size_t count = 0; ///< pairs
    std::uint32_t item_room = 0, unsure_room = 0;
    MeshWalkCounts counts;

    Batch() = default;
    ~Batch()
    {
        if (fence) glDeleteSync(fence);
    }
    Batch(const Batch&) = delete;
    Batch& operator=(const Batch&) = delete;

    std::uint32_t first_of(std::uint32_t room) const { return std::min(room, read_at_once(count)); }
    // Positions in `out` (words). In the readback, the first entries of the lists follow the results.
    std::size_t unsure_at() const { return header_words + result_words * count; }
    std::size_t wanted_at() const { return unsure_at() + std::size_t{unsure_words} * unsure_room; }
    std::size_t out_bytes() const { return 4 * (wanted_at() + wanted_words * wanted_room); }
    std::size_t wanted_in_readback() const { return unsure_at() + unsure_words * first_of(unsure_room); }
    std::size_t readback_bytes() const { return 4 * (wanted_in_readback() + wanted_words * first_of(wanted_room)); }
    const std::uint32_t* read() const { return reinterpret_cast<const std::uint32_t*>(readback.data()); }
};

class GlMeshWalks final : public MeshWalks {
public:
    explicit GlMeshWalks(const MeshWalkOptions& options)
        : options_(options), context_((step(MeshWalkStep::context), options.gpu)), most_(allowed_bytes(options)),
          trees_(most_), prepare_((check_doubles(), step(MeshWalkStep::shaders), "gl, prepare"),
                                  {{GL_COMPUTE_SHADER, edited(options, WalkShaders::prepare())}}),
          walk_("gl, walk", {{GL_COMPUTE_SHADER, edited(options, WalkShaders::walk())}}),
          item_room_(std::max<std::uint32_t>(options.first_items, 64))
    {
        GLint blocks = 0;
        glGetIntegerv(GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS, &blocks);
        if (blocks < 8) throw GpuLost(fmt::format("gl: a shader may use {} buffers; the walk needs 8", blocks));
        context_.check("the making of gl");
    }
    ~GlMeshWalks() override { context_.use_at_end(); }

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

    std::span<MeshWalkPair> begin(std::size_t pairs) override
    {
        ONCOLLIDE_ASSERT(pairs > 0 && pairs <= most_pairs && under_way_ < most_batches);
        context_.use();
        Batch& batch = batches_[next_];
        batch.count = pairs, batch.item_room = item_room_, batch.unsure_room = unsure_room_, batch.counts = {};
        batch.upload.make_room(head_bytes + pairs * sizeof(MeshWalkPair), "gl, pairs");
        return {reinterpret_cast<MeshWalkPair*>(batch.upload.data() + head_bytes), pairs};
    }

    void submit(bool by_distance) override
    {
        context_.use();
        Batch& batch = batches_[next_];
        batch.clock.mark(0);
        step(MeshWalkStep::trees);
        batch.counts.tree_bytes = trees_.upload();
        context_.check("the upload of trees");
        make_room(batch);
        step(MeshWalkStep::upload);
        upload(batch);
        batch.clock.mark(1);
        step(MeshWalkStep::dispatch);
        dispatch(batch, by_distance);
        queue_readback(batch);
        next_ = (next_ + 1) % most_batches, ++under_way_;
    }

    std::span<const MeshWalkResult> collect() override
    {
        ONCOLLIDE_ASSERT(under_way_ > 0);
        context_.use();
        Batch& batch = batches_[(next_ + most_batches - under_way_) % most_batches];
        --under_way_;
        step(MeshWalkStep::readback);
        MeshWalkCounts& counts = batch.counts;
        counts.wait_ms = wait_for(batch.fence);
        context_.check("a batch of walks");
        std::array<std::uint32_t, header_words> head;
        std::copy_n(batch.read(), header_words, head.begin());
        read_list(batch, unsure_, std::min(head[header::unsure], batch.unsure_room), batch.unsure_room,
                  batch.unsure_at(), batch.unsure_at());
        read_list(batch, wanted_, std::min(head[header::wanted], wanted_room), wanted_room, batch.wanted_at(),
                  batch.wanted_in_readback());
        counts.batches = 1, counts.pairs = batch.count;
        counts.box_rows = head[header::box_rows], counts.triangle_pairs = head[header::triangles];
        counts.unsure_pairs = head[header::unsure];
        const StageClock& clock = batch.clock;
        counts.upload_ms = clock.ms(0), counts.prepare_ms = clock.ms(1), counts.walk_ms = clock.ms(2);
        counts.readback_ms = clock.ms(3);
        enlarge(batch, head);
        counts_ += counts, last_ = counts;
        return {reinterpret_cast<const MeshWalkResult*>(batch.read() + header_words), batch.count};
    }
    std::span<const UnsureTriangles> unsure() const override { return unsure_; }
    std::span<const WantedNode> wanted() const override { return wanted_; }
    const MeshWalkCounts& batch() const override { return last_; }
    const MeshWalkCounts& counts() const override { return counts_; }
    std::size_t bytes() const override
    {
        std::size_t all = trees_.bytes() + frames_.bytes() + items_.bytes();
        for (const Batch& batch : batches_) all += batch.pairs.bytes() + batch.out.bytes();
        return all;
    }

private:
    static constexpr std::size_t head_bytes = 4 * header_words;

    void step(MeshWalkStep which)
    {
        if (options_.before) options_.before(which);
    }
    void check_doubles() { step(MeshWalkStep::doubles), need_doubles(options_, context_.info()); }

    void make_room(Batch& batch)
    {
        grow(frames_, batch.count * frame_bytes, 0, most_, "gl, frames");
        grow(items_, std::size_t{2} * 4 * item_words * batch.item_room, 0, most_, "gl, items");
        grow(batch.pairs, batch.count * sizeof(MeshWalkPair), 0, most_, "gl, pairs");
        grow(batch.out, batch.out_bytes(), 0, most_, "gl, results");
        batch.readback.make_room(batch.readback_bytes(), "gl, results");
    }

    void upload(Batch& batch)
    {
        std::array<std::uint32_t, header_words> head{};
        for (std::uint32_t round = 0; round < rounds; ++round) {
            std::uint32_t* const groups = &head[header::groups + 3 * round];
            groups[1] = groups[2] = 1; // the shaders count groups[0]
        }
        std::memcpy(batch.upload.data(), head.data(), head_bytes);
        const std::size_t pair_bytes = batch.count * sizeof(MeshWalkPair);
        const auto copy = [&](const Buffer& target, std::size_t from, std::size_t bytes) {
            glCopyNamedBufferSubData(batch.upload.name(), target.name(), static_cast<GLintptr>(from), 0,
                                     static_cast<GLsizeiptr>(bytes));
        };
        copy(batch.out, 0, head_bytes), copy(batch.pairs, head_bytes, pair_bytes);
        batch.counts.bytes_up = pair_bytes + head_bytes;
    }

    void dispatch(Batch& batch, bool by_distance)
    {
        trees_.bind();
        const auto bind = [](unsigned where, const Buffer& buffer) {
            glBindBufferBase(GL_SHADER_STORAGE_BUFFER, where, buffer.name());
        };
        bind(slot::pairs, batch.pairs), bind(slot::frames, frames_), bind(slot::items, items_);
        bind(slot::out, batch.out);
        glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, batch.out.name());
        use(prepare_, batch, 0, by_distance);
        glDispatchCompute(static_cast<GLuint>((batch.count + 63) / 64), 1, 1);
        for (GLuint round = 0; round < rounds; ++round) {
            glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
            if (round == 0) batch.clock.mark(2);
            use(walk_, batch, round, by_distance);
            glDispatchComputeIndirect(static_cast<GLintptr>(4 * (header::groups + 3 * round)));
        }
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
        batch.clock.mark(3);
        batch.counts.dispatches = 1 + rounds;
        context_.check("the dispatch of walks");
    }

    void use(const Program& program, const Batch& batch, GLuint round, bool by_distance)
    {
        glUseProgram(program.name());
        const auto set = [](GLint where, std::size_t value) { glUniform1ui(where, static_cast<GLuint>(value)); };
        set(0, batch.count), set(1, batch.item_room), set(2, batch.unsure_room), set(3, wanted_room);
        set(4, round), set(5, row_limits[round]), set(6, by_distance);
        // Enough groups to fill a GPU; teams take items until there are none. llvmpipe ends a loop after some time, so
        // a group must not have too many items.
        set(7, context_.info().software ? 1024 : 4096);
    }

    void queue_readback(Batch& batch)
    {
        const auto copy = [&](std::size_t from, std::size_t to, std::size_t words) {
            glCopyNamedBufferSubData(batch.out.name(), batch.readback.name(), static_cast<GLintptr>(4 * from),
                                     static_cast<GLintptr>(4 * to), static_cast<GLsizeiptr>(4 * words));
        };
        copy(0, 0, batch.wanted_in_readback()); // the list of unsure pairs follows the results
        copy(batch.wanted_at(), batch.wanted_in_readback(), wanted_words * batch.first_of(wanted_room));
        batch.clock.mark(4);
        glMemoryBarrier(GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
        if (batch.fence) glDeleteSync(batch.fence);
        batch.fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
        glFlush();
        batch.counts.bytes_down = batch.readback_bytes();
    }

    /// Reads the first `count` entries of a list, of which the readback has some.
    /// @param at           position in `out` (words)
    /// @param in_readback  position in the readback (words)
    template <class Entry>
    void read_list(Batch& batch, std::vector<Entry>& list, std::uint32_t count, std::uint32_t room, std::size_t at,
                   std::size_t in_readback)
    {
        static_assert(sizeof(Entry) == 4 * unsure_words && unsure_words == wanted_words);
        const std::uint32_t there = std::min(count, batch.first_of(room));
        list.resize(count);
        std::memcpy(list.data(), batch.read() + in_readback, there * sizeof(Entry));
        if (count == there) return;
        const std::size_t bytes = (count - there) * sizeof(Entry);
        glGetNamedBufferSubData(batch.out.name(), static_cast<GLintptr>(4 * at + there * sizeof(Entry)),
                                static_cast<GLsizeiptr>(bytes), list.data() + there);
        context_.check("the reading of a list");
        batch.counts.bytes_down += bytes;
    }

    /// Makes room for later batches if this one had too little.
    void enlarge(Batch& batch, const std::array<std::uint32_t, header_words>& head)
    {
        const std::uint32_t items = *std::max_element(&head[header::queued], &head[header::queued] + rounds + 1),
                            unsure = head[header::unsure];
        batch.counts.full = items > batch.item_room || unsure > batch.unsure_room;
        const auto most = [&](std::size_t bytes) { return static_cast<std::uint32_t>(most_ / (2 * bytes)); };
        if (items > item_room_) item_room_ = std::min(2 * items, std::max(item_room_, most(2 * 4 * item_words)));
        if (unsure > unsure_room_) unsure_room_ = std::min(2 * unsure, std::max(unsure_room_, most(4 * unsure_words)));
    }

    MeshWalkOptions options_;
    Context context_; // comes before all objects that live in it
    std::size_t most_;
    TreeStore trees_;
    Program prepare_, walk_;
    Buffer frames_, items_;
    std::array<Batch, most_batches> batches_;
    std::size_t next_ = 0, under_way_ = 0; ///< the batch that begins next; batches that were not collected
    std::uint32_t item_room_, unsure_room_ = first_unsure_room;
    std::vector<UnsureTriangles> unsure_;
    std::vector<WantedNode> wanted_;
    MeshWalkCounts counts_, last_;
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
