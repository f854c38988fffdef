// A batch is three dispatches; nothing is read back between them:
//
//     rows ── plan ──> tiles ── test ──> one byte per row, masks of triangles, room for lists ── scatter ──> lists
//
// A tile is at most eight triangles of one row, tested by one invocation, so short lists fill the GPU as well as long
// ones. The invocation that finishes a row's last tile reserves the room for its list. A list keeps one run of entries
// per octant, so a child's row reads exactly the triangles that enter it. Atomic counters allocate tiles and lists; if
// one passes its buffer's end, the batch has no lasting effect, and is repeated with a larger buffer.
#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include <oncollide/narrowphase/gl/batch_clock.hpp>
#include <oncollide/narrowphase/gl/context.hpp>
#include <oncollide/narrowphase/gl/list_store.hpp>
#include <oncollide/narrowphase/gl/octant_shaders.hpp>
#include <oncollide/narrowphase/gl/primitive_store.hpp>
#include <oncollide/narrowphase/spheres/octant_cell.hpp>

namespace oncollide {

namespace {

using namespace gl;

constexpr std::uint32_t none = 0xffffffffu;

/// The layout of a row in the shaders.
struct GpuRow {
    float centre[3], slack;
    float half[3];
    std::uint32_t boxes;
    std::uint32_t first_primitive, parent_list, octant_or_count, own_list;
};
static_assert(sizeof(GpuRow) == 4 * words::row);

std::size_t allowed_bytes(const GlComputeOptions& options)
{
    GLint64 block = 0;
    glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
    const std::size_t most = std::min<std::size_t>(static_cast<std::size_t>(block), std::size_t{1} << 31);
    return options.most_buffer_bytes ? std::min(options.most_buffer_bytes, most) : most;
}

class GlComputeBackend final : public OcclusionBackend {
public:
    explicit GlComputeBackend(const GlComputeOptions& options)
        : context_(options.gpu), most_(allowed_bytes(options)), primitives_(most_),
          lists_(most_, options.first_entries), plan_("gl-compute, plan", {{GL_COMPUTE_SHADER, OctantShaders::plan()}}),
          test_("gl-compute, test", {{GL_COMPUTE_SHADER, OctantShaders::test()}}),
          scatter_("gl-compute, scatter", {{GL_COMPUTE_SHADER, OctantShaders::scatter()}}),
          oversize_(make_cpu_backend())
    {
        context_.check("the making of gl-compute");
    }
    ~GlComputeBackend() override
    {
        context_.use_at_end();
        if (fence_) glDeleteSync(fence_);
    }

    std::string name() const override { return fmt::format("gl-compute ({})", context_.info().renderer); }
    std::string renderer() const override { return context_.info().renderer; }
    double error(double) const override { return 0; }

    void attach(std::uint32_t tree, Surface surface) override
    {
        context_.use();
        if (trees_.size() <= tree) trees_.resize(tree + 1);
        const std::optional<std::size_t> first = primitives_.add(surface.primitives);
        context_.check("the upload of a surface");
        trees_[tree].emplace(Tree{surface.root,
                                  surface.boxes,
                                  first.has_value(),
                                  first.value_or(0),
                                  surface.primitives.size(),
                                  surface.inside,
                                  {}});
        if (!trees_[tree]->on_gpu) oversize_->attach(tree, std::move(surface));
    }
    bool attached(std::uint32_t tree) const override { return tree < trees_.size() && trees_[tree]; }
    void detach(std::uint32_t tree) override
    {
        if (!attached(tree)) return;
        Tree& t = *trees_[tree];
        if (!t.on_gpu) oversize_->detach(tree);
        if (t.on_gpu) primitives_.remove(t.first, t.count);
        for (ListId list : t.lists) lists_.release(list);
        trees_[tree].reset();
    }

    void submit(std::span<const OctantRow> rows, int threads) override
    {
        context_.use();
        requested_ = rows;
        gpu_rows_.clear(), oversize_rows_.clear(), results_.assign(rows.size(), {}), work_ = {};
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const OctantRow& row = rows[i];
            Tree& tree = *trees_[row.tree];
            if (!tree.on_gpu) {
                oversize_rows_.push_back(row);
                continue;
            }
            if (row.keep_list) {
                results_[i].list = lists_.add();
                remember(tree.lists, results_[i].list);
            }
            gpu_rows_.push_back(gpu_row(tree, row, results_[i].list));
        }
        if (!gpu_rows_.empty()) {
            lists_.make_list_room();
            dispatch();
        }
        oversize_->submit(oversize_rows_, threads);
    }

    BatchWork collect(std::span<OctantResult> results) override
    {
        context_.use();
        if (!gpu_rows_.empty()) {
            while (!finished()) {
                ++work_.repeats;
                dispatch();
            }
        }
        oversize_results_.resize(oversize_rows_.size());
        oversize_->collect(oversize_results_);
        std::size_t gpu = 0, oversize = 0;
        for (std::size_t i = 0; i < requested_.size(); ++i) {
            const Tree& tree = *trees_[requested_[i].tree];
            if (!tree.on_gpu) {
                results[i] = oversize_results_[oversize++];
                continue;
            }
            const std::uint8_t grey = masks_[gpu++];
            results[i] = results_[i];
            results[i].grey = grey;
            if (!tree.inside.empty())
                results[i].grey |= static_cast<std::uint8_t>(
                    octants_inside(tree.inside, octant_cell(tree.root, requested_[i].cell), grey));
        }
        return work_;
    }

    void release(std::uint32_t tree, ListId list) override
    {
        if (list == all_triangles || !attached(tree)) return;
        Tree& t = *trees_[tree];
        if (!t.on_gpu) return oversize_->release(tree, list);
        forget(t.lists, list);
        lists_.release(list);
    }

    void read(std::span<const ListRead> reads, std::vector<std::uint32_t>& triangles,
              std::vector<std::size_t>& ends) override
    {
        context_.use();
        std::vector<ListRead> far; // runs of reads that the list store serves
        const auto flush = [&] {
            lists_.read(far, triangles, ends);
            far.clear();
        };
        for (const ListRead& r : reads) {
            const Tree& tree = *trees_[r.tree];
            if (tree.on_gpu && r.list != all_triangles) {
                far.push_back(r);
                continue;
            }
            flush();
            if (!tree.on_gpu) {
                oversize_->read(std::span(&r, 1), triangles, ends);
                continue;
            }
            for (std::uint32_t i = 0; i < tree.count; ++i) triangles.push_back(i);
            ends.push_back(triangles.size());
        }
        flush();
        context_.check("the reading of lists");
    }

    std::size_t bytes() const override { return primitives_.bytes() + lists_.bytes() + oversize_->bytes(); }

private:
    struct Tree {
        RootCell root;
        bool boxes, on_gpu;
        std::size_t first, count; ///< primitives
        std::vector<std::array<double, 4>> inside;
        std::vector<ListId> lists; ///< kept lists, unordered
    };

    void remember(std::vector<ListId>& lists, ListId list)
    {
        const auto number = static_cast<std::size_t>(list);
        if (place_in_tree_.size() <= number) place_in_tree_.resize(number + 1);
        place_in_tree_[number] = static_cast<std::uint32_t>(lists.size());
        lists.push_back(list);
    }
    void forget(std::vector<ListId>& lists, ListId list)
    {
        const std::uint32_t place = place_in_tree_[static_cast<std::size_t>(list)];
        lists[place] = lists.back();
        place_in_tree_[static_cast<std::size_t>(lists[place])] = place;
        lists.pop_back();
    }

    static GpuRow gpu_row(const Tree& tree, const OctantRow& row, ListId own)
    {
        const OctantCell cell = octant_cell(tree.root, row.cell);
        const bool all = row.list == all_triangles;
        GpuRow r{};
        std::copy_n(cell.centre, 3, r.centre), std::copy_n(cell.half, 3, r.half);
        r.slack = cell.slack, r.boxes = tree.boxes;
        r.first_primitive = static_cast<std::uint32_t>(tree.first);
        r.parent_list = static_cast<std::uint32_t>(row.list); // all_triangles equals `none`
        r.octant_or_count = all ? static_cast<std::uint32_t>(tree.count) : octant_of(row.cell);
        r.own_list = static_cast<std::uint32_t>(own);
        return r;
    }

    std::size_t out_bytes() const { return 4 * words::header + (gpu_rows_.size() + 3) / 4 * 4; }

    /// Queues all commands of the batch.
    void dispatch()
    {
        const std::size_t count = gpu_rows_.size();
        grow(rows_, count * sizeof(GpuRow), 0, most_, "rows");
        grow(cursors_, 4 * words::cursors * count, 0, most_, "rows");
        grow(tiles_, 4 * words::tile * std::max<std::size_t>(4 * count, 1024), 0, most_, "tiles");
        grow(out_, out_bytes(), 0, most_, "results");
        readback_.make_room(out_bytes(), "gl-compute, results");
        upload(count * sizeof(GpuRow));
        lists_.bind();
        const auto bind = [](unsigned where, const Buffer& buffer) {
            glBindBufferBase(GL_SHADER_STORAGE_BUFFER, where, buffer.name());
        };
        bind(binding::primitives, primitives_.buffer()), bind(binding::rows, rows_), bind(binding::cursors, cursors_);
        bind(binding::tiles, tiles_), bind(binding::out, out_);
        // Few groups on a software renderer with few threads, enough to fill a GPU otherwise.
        const auto for_rows = static_cast<GLuint>(std::min<std::size_t>((count + 63) / 64, 65535));
        const GLuint for_tiles = context_.info().software ? std::min(4 * for_rows + 16, 256u) : 2048;
        const bool keep = std::any_of(gpu_rows_.begin(), gpu_rows_.end(), [](auto& r) { return r.own_list != none; });
        run(plan_, for_rows);
        run(test_, for_tiles);
        if (keep) run(scatter_, for_tiles);
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        glCopyNamedBufferSubData(out_.name(), readback_.name(), 0, 0, static_cast<GLsizeiptr>(out_bytes()));
        clock_.stop();
        glMemoryBarrier(GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT);
        if (fence_) glDeleteSync(fence_);
        fence_ = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
        glFlush();
        work_.bytes += count * sizeof(GpuRow) + 2 * out_bytes();
    }

    /// Copies the rows and the initial results to the GPU, and starts the clock. The same call writes all of the
    /// results' buffer: NVIDIA's driver (580) lets a small write from the CPU overtake a clear that was queued before
    /// it.
    void upload(std::size_t row_bytes)
    {
        upload_.make_room(row_bytes + out_bytes(), "gl-compute, rows");
        const std::uint32_t header[words::header] = {0, static_cast<std::uint32_t>(lists_.entries()), 0, 0};
        std::memcpy(upload_.data(), gpu_rows_.data(), row_bytes);
        std::memcpy(upload_.data() + row_bytes, header, sizeof header);
        std::memset(upload_.data() + row_bytes + sizeof header, 0, out_bytes() - sizeof header);
        clock_.start();
        const auto copy = [&](const Buffer& to, std::size_t from, std::size_t bytes) {
            glCopyNamedBufferSubData(upload_.name(), to.name(), static_cast<GLintptr>(from), 0,
                                     static_cast<GLsizeiptr>(bytes));
        };
        copy(rows_, 0, row_bytes), copy(out_, row_bytes, out_bytes());
    }

    void run(const Program& program, GLuint groups)
    {
        glUseProgram(program.name());
        glUniform1ui(0, static_cast<GLuint>(gpu_rows_.size()));
        glUniform1ui(1, static_cast<GLuint>(tiles_.bytes() / (4 * words::tile)));
        glUniform1ui(2, static_cast<GLuint>(lists_.entry_room()));
        glDispatchCompute(groups, 1, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    }

    /// Waits for the batch. False: a buffer was too small, and has been enlarged.
    bool finished()
    {
        work_.wait_ms += wait_for(fence_);
        context_.check("a batch of octant tests");
        work_.gpu_ms += clock_.ms();
        std::uint32_t header[words::header];
        std::memcpy(header, readback_.data(), sizeof header);
        const std::size_t tiles = header[0], entries = header[1], tile_bytes = 4 * words::tile;
        if (tiles > tiles_.bytes() / tile_bytes) {
            grow(tiles_, tiles * tile_bytes, 0, most_, "tiles");
            return false;
        }
        if (entries > lists_.entry_room()) {
            lists_.make_entry_room(entries - lists_.entries());
            return false;
        }
        lists_.commit(entries);
        masks_ = reinterpret_cast<const std::uint8_t*>(readback_.data()) + sizeof header;
        return true;
    }

    Context context_; // comes first, because all members below live in this context
    std::size_t most_;
    PrimitiveStore primitives_;
    ListStore lists_;
    Program plan_, test_, scatter_;
    Buffer rows_, cursors_, tiles_, out_;
    MappedBuffer upload_{GL_MAP_WRITE_BIT}, readback_{GL_MAP_READ_BIT};
    GLsync fence_ = nullptr;
    BatchClock clock_;

    std::vector<std::optional<Tree>> trees_;
    std::vector<std::uint32_t> place_in_tree_;   ///< by list: its index in Tree::lists
    std::unique_ptr<OcclusionBackend> oversize_; ///< serves surfaces that do not fit
    std::span<const OctantRow> requested_;
    std::vector<GpuRow> gpu_rows_;
    std::vector<OctantRow> oversize_rows_;
    std::vector<OctantResult> results_, oversize_results_;
    const std::uint8_t* masks_ = nullptr; ///< by GPU row
    BatchWork work_;
};

} // namespace

std::unique_ptr<OcclusionBackend> make_gl_compute_backend(const GlComputeOptions& options)
{
    return std::make_unique<GlComputeBackend>(options);
}

} // namespace oncollide
