// The paper's method of finding the octants that a surface enters: make the octant the view volume, draw the mesh, and
// query the GPU whether any fragment was drawn.
//
//        camera      near          far          The camera stands one box length outside the octant and looks along
//          o . . . . +--------------+           x, then y, then z; near = 1 and far = 2 box lengths, so clipping
//          <- 1 ->   |    octant    |           leaves the part of the mesh within the octant. No depth test,
//                    +--------------+           no culling: any fragment counts.
//
// A fragment is proof. No fragment from three sides is no proof: triangles seen edge-on, or between pixel centres,
// leave none.
//
// Source: Franquesa-Niubó and Rodríguez González, "Sphere-trees generation as needed in real time to speed up collision
// detection", GRAPP 2006, section 4.
#include <oncollide/narrowphase/gl/gpu.hpp>

#include <algorithm>
#include <chrono>
#include <optional>

#include <fmt/format.h>

#include <oncollide/narrowphase/gl/batch_clock.hpp>
#include <oncollide/narrowphase/gl/context.hpp>
#include <oncollide/narrowphase/gl/octant_queries.hpp>
#include <oncollide/narrowphase/gl/query_mesh.hpp>
#include <oncollide/narrowphase/spheres/listed_surfaces.hpp>

namespace oncollide {

namespace {

using Primitives = GlQueryOptions::Primitives;
using Draw = GlQueryOptions::Draw;

constexpr std::size_t most_in_flight = gl::OctantQueries::most_in_flight;

template <std::size_t N>
const char* name_in(const char* const (&names)[N], std::size_t value, const char* option)
{
    if (value >= N) throw Error(ErrorKind::usage, fmt::format("gl-query: there is no {} number {}", option, value));
    return names[value];
}

/// Throws Error{usage} for invalid options.
std::string describe(const GlQueryOptions& o)
{
    if (o.viewport < 1 || o.viewport > 1024)
        throw Error(ErrorKind::usage, fmt::format("gl-query: viewport is {} pixels; 1 to 1024 are valid", o.viewport));
    return fmt::format("gl-query ({} px, {}, {}, {}{})", o.viewport,
                       name_in({"soup", "indexed", "strips"}, static_cast<std::size_t>(o.primitives), "primitives"),
                       name_in({"passed", "any"}, static_cast<std::size_t>(o.samples), "samples"),
                       name_in({"mesh", "inherited"}, static_cast<std::size_t>(o.draw), "draw"),
                       o.inflated ? ", inflated" : "");
}

/// A part of a strip is not a strip, so strips always draw the whole mesh.
GlQueryOptions usable(GlQueryOptions options)
{
    if (options.primitives == Primitives::strips) options.draw = Draw::mesh;
    return options;
}

class GlQueryBackend final : public OcclusionBackend {
public:
    explicit GlQueryBackend(const GlQueryOptions& options)
        : options_(usable(options)), name_(describe(options_)), context_(options_.gpu),
          queries_(options_.samples == GlQueryOptions::Samples::any ? GL_ANY_SAMPLES_PASSED : GL_SAMPLES_PASSED,
                   options_.viewport, options_.inflated)
    {
        context_.check("setting up gl-query");
    }
    ~GlQueryBackend() override { context_.use_at_end(); }

    std::string name() const override { return name_; }
    std::string renderer() const override { return context_.info().renderer; }

    /// A fragment is a pixel centre within the triangle, after clipping to the view volume and snapping of the corners
    /// to at most 1/16 of a pixel (GL_SUBPIXEL_BITS is at least 4). The triangle therefore has a point within the
    /// volume's depth and within 1/16 pixel of that centre. Pixel centres lie half a texel inside the plain volume, so
    /// that point is in the octant except for float rounding, which test_error() covers. The inflated volume is half a
    /// texel deeper on either side, and its outermost pixel centres are just inside the octant: at most 1.02 times half
    /// a texel. Another half texel allows for hardware that clips by a depth interpolated at the pixel's centre.
    double error(double half) const override { return (options_.inflated ? 2 : 1) * half / options_.viewport; }

    void attach(std::uint32_t tree, Surface surface) override
    {
        context_.use();
        if (meshes_.size() <= tree) meshes_.resize(tree + 1);
        meshes_[tree].reset();
        if (!surface.boxes) meshes_[tree].emplace(surface.primitives, options_.primitives);
        surfaces_.attach(tree, std::move(surface));
        context_.check("copying a mesh to the GPU");
    }
    bool attached(std::uint32_t tree) const override { return surfaces_.attached(tree); }
    void detach(std::uint32_t tree) override
    {
        if (!attached(tree)) return;
        context_.use_at_end();
        meshes_[tree].reset();
        surfaces_.detach(tree);
    }

    void submit(std::span<const OctantRow> rows, int threads) override
    {
        context_.use();
        rows_ = rows, work_ = {}, axis_ = 0, begin_ = 0;
        // Half a texel of an octant, as a fraction of its cell.
        const float inflation = options_.inflated ? 0.5f / static_cast<float>(options_.viewport) : 0.0f;
        surfaces_.find(rows, {.boxes = true, .inflation = inflation, .all = options_.draw == Draw::inherited}, threads);
        settle_without_queries();
        if (open_.empty()) return;
        clock_.start();
        issue();
        glFlush();
    }

    BatchWork collect(std::span<OctantResult> results) override
    {
        ONCOLLIDE_ASSERT(results.size() == results_.size());
        context_.use();
        if (!open_.empty()) {
            do read_back();
            while (issue_next());
            clock_.stop();
            work_.gpu_ms = clock_.ms();
        }
        context_.check("a batch of occlusion queries");
        std::copy(results_.begin(), results_.end(), results.begin());
        return work_;
    }

    void release(std::uint32_t tree, ListId list) override { surfaces_.release(tree, list); }
    void read(std::span<const ListRead> reads, std::vector<std::uint32_t>& triangles,
              std::vector<std::size_t>& ends) override
    {
        surfaces_.read(reads, triangles, ends);
    }
    std::size_t bytes() const override
    {
        std::size_t sum = surfaces_.bytes() + stream_.bytes();
        for (const auto& mesh : meshes_)
            if (mesh) sum += mesh->bytes();
        return sum;
    }

private:
    struct OpenOctant { ///< an octant without a fragment so far
        std::uint32_t row;
        unsigned octant;
    };

    /// Sets lists and results that need no queries: insides of solid shapes, and maps, whose boxes are solid while a
    /// query would only see their faces. All other octants become open.
    void settle_without_queries()
    {
        open_.clear(), results_.resize(rows_.size());
        for (std::uint32_t i = 0; i < rows_.size(); ++i) {
            const OctantRow& row = rows_[i];
            const bool boxes = surfaces_.surface(row.tree).boxes;
            results_[i].grey = boxes ? surfaces_.entered(i) : surfaces_.inside(i);
            results_[i].list = row.keep_list ? surfaces_.keep(row.tree, i) : all_triangles;
            for (unsigned k = 0; k < 8 && !boxes; ++k)
                if (!seen({i, k})) open_.push_back({i, k});
        }
    }

    bool seen(const OpenOctant& q) const { return results_[q.row].grey >> q.octant & 1; }

    /// The open octants whose queries are in flight together.
    std::span<const OpenOctant> in_flight() const
    {
        return std::span(open_).subspan(begin_, std::min(most_in_flight, open_.size() - begin_));
    }

    void issue()
    {
        if (options_.draw == Draw::inherited) stream_triangles();
        queries_.look_along(axis_);
        const auto octants = in_flight();
        for (std::size_t i = 0; i < octants.size(); ++i) {
            const OctantRow& row = rows_[octants[i].row];
            const CellKey octant = child_cell(row.cell, octants[i].octant);
            queries_.issue(i, octant_cell(surfaces_.surface(row.tree).root, octant), [&] {
                const gl::QueryMesh& mesh = *meshes_[row.tree];
                if (options_.draw == Draw::mesh)
                    mesh.draw();
                else
                    stream_.draw(mesh, i);
            });
        }
        work_.queries += octants.size();
    }

    /// Uploads the triangles whose boxes meet each octant in flight.
    void stream_triangles()
    {
        stream_.clear();
        for (const OpenOctant& q : in_flight())
            stream_.add(*meshes_[rows_[q.row].tree], surfaces_.triangles(q.row, q.octant));
        work_.bytes += stream_.upload();
    }

    void read_back()
    {
        const auto from = std::chrono::steady_clock::now();
        const auto octants = in_flight();
        const std::span<const GLuint> samples = queries_.read(octants.size());
        for (std::size_t i = 0; i < octants.size(); ++i)
            results_[octants[i].row].grey |= static_cast<std::uint8_t>((samples[i] != 0) << octants[i].octant);
        work_.bytes += samples.size_bytes();
        work_.wait_ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - from).count();
    }

    /// Issues queries of the next octants along this axis; after the last one, of the octants without a fragment along
    /// the next axis. False: none is left.
    bool issue_next()
    {
        begin_ += in_flight().size();
        if (begin_ == open_.size()) {
            std::erase_if(open_, [&](const OpenOctant& q) { return seen(q); });
            begin_ = 0;
            if (++axis_ == 3 || open_.empty()) return false;
        }
        issue();
        return true;
    }

    GlQueryOptions options_;
    std::string name_;
    gl::Context context_; ///< comes first, because all members below live in this context
    gl::OctantQueries queries_;
    gl::BatchClock clock_;
    gl::TriangleStream stream_;
    std::vector<std::optional<gl::QueryMesh>> meshes_; ///< by tree; none for maps
    ListedSurfaces surfaces_;

    // The current batch.
    std::span<const OctantRow> rows_;
    std::vector<OctantResult> results_;
    std::vector<OpenOctant> open_;
    std::size_t begin_ = 0; ///< index in open_ of the first octant in flight
    int axis_ = 0;
    BatchWork work_;
};

} // namespace

std::unique_ptr<OcclusionBackend> make_gl_query_backend(const GlQueryOptions& options)
{
    return std::make_unique<GlQueryBackend>(options);
}

} // namespace oncollide
