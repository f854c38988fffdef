// Several viewing volumes per pair: boxes around parts of one body, in whose frame they are aligned. The other body is
// drawn in each, and an occlusion query reports whether there was a fragment.
//
// The paper's text was not at hand; these choices follow its title and its abstract idea only: the volumes are the
// boxes of eight parts of the body with fewer triangles, halved along the longest axis; each is seen along x, then y,
// then z of that body, until an axis shows a fragment; flat volumes are 1/64 of the largest extent thick.
#include <oncollide/narrowphase/gl/culling/pair_culling.hpp>

#include <algorithm>
#include <map>
#include <vector>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/gl/batch_clock.hpp>
#include <oncollide/narrowphase/gl/context.hpp>
#include <oncollide/narrowphase/gl/culling/culled_mesh.hpp>
#include <oncollide/narrowphase/gl/octant_queries.hpp>

namespace oncollide {

namespace {

constexpr std::size_t most_volumes_in_flight = 4096;

class ViewingVolumes final : public PairCulling {
public:
    explicit ViewingVolumes(const ViewingVolumesOptions& options)
        : options_(checked(options)), context_(options.gpu), view_(options.viewport, false),
          queries_(GL_ANY_SAMPLES_PASSED, most_volumes_in_flight)
    {
        context_.check("setting up viewing volumes");
    }
    ~ViewingVolumes() override { context_.use_at_end(); }

    std::string name() const override
    {
        return fmt::format("viewing volumes ({} px, {} per body)", options_.viewport, options_.volumes);
    }
    std::string renderer() const override { return context_.info().renderer; }

    void attach(std::uint32_t number, const Mesh& mesh) override
    {
        context_.use();
        meshes_.erase(number);
        const auto volumes = static_cast<std::size_t>(options_.volumes);
        meshes_.try_emplace(number, mesh, (mesh.triangles.size() + volumes - 1) / volumes, false);
        context_.check("copying a mesh to the GPU");
    }

    CullingWork cull(std::span<const CulledBody> bodies, std::span<const BodyPair> pairs,
                     std::span<std::uint8_t> left) override
    {
        context_.use();
        bodies_ = bodies, pairs_ = pairs, left_ = left, work_ = {};
        std::fill(left.begin(), left.end(), std::uint8_t{0});
        clock_.start();
        for (const int axis : {0, 1, 2}) look_along(axis);
        clock_.stop();
        work_.gpu_ms = clock_.ms();
        context_.check("queries of viewing volumes");
        return work_;
    }

private:
    static ViewingVolumesOptions checked(const ViewingVolumesOptions& o)
    {
        if (o.viewport < 1 || o.viewport > 1024)
            throw Error(ErrorKind::usage,
                        fmt::format("viewing volumes: viewport is {} pixels; 1 to 1024 are valid", o.viewport));
        if (o.volumes < 1)
            throw Error(ErrorKind::usage, fmt::format("viewing volumes: {} per body; at least 1", o.volumes));
        return o;
    }

    const gl::CulledMesh& mesh(std::uint32_t body) const { return meshes_.at(bodies_[body].mesh); }

    /// Queries the volumes of the pairs that no fragment has kept so far.
    void look_along(int axis)
    {
        view_.look_along(axis);
        asked_.clear();
        for (std::uint32_t i = 0; i < pairs_.size(); ++i) {
            if (left_[i]) continue;
            auto [owner, drawn] = pairs_[i];
            if (mesh(drawn).whole().count < mesh(owner).whole().count) std::swap(owner, drawn);
            const Eigen::Isometry3d into = bodies_[owner].pose.inverse(Eigen::Isometry) * bodies_[drawn].pose;
            const double thinnest = mesh(owner).whole().box.half_extent().maxCoeff() / 64;
            for (const gl::CulledMesh::Run& run : mesh(owner).runs()) {
                if (asked_.size() == most_volumes_in_flight) read();
                view_.look_at(run.box.centre(), run.box.half_extent().cwiseMax(std::max(thinnest, 1e-30)));
                view_.place(mesh(drawn), into);
                glBeginQuery(GL_ANY_SAMPLES_PASSED, queries_[asked_.size()]);
                mesh(drawn).draw(0, mesh(drawn).whole().count);
                glEndQuery(GL_ANY_SAMPLES_PASSED);
                asked_.push_back(i);
            }
        }
        read();
    }

    void read()
    {
        const std::span<const GLuint> seen = queries_.read(asked_.size());
        for (std::size_t k = 0; k < asked_.size(); ++k) left_[asked_[k]] |= seen[k] != 0;
        work_.queries += asked_.size();
        asked_.clear();
    }

    ViewingVolumesOptions options_;
    gl::Context context_; ///< comes first, because all members below live in this context
    gl::CullingView view_;
    gl::Queries queries_;
    gl::BatchClock clock_;
    std::map<std::uint32_t, gl::CulledMesh> meshes_;

    // The current call.
    std::span<const CulledBody> bodies_;
    std::span<const BodyPair> pairs_;
    std::span<std::uint8_t> left_;
    std::vector<std::uint32_t> asked_; ///< by query: the pair
    CullingWork work_;
};

} // namespace

std::unique_ptr<PairCulling> make_viewing_volumes(const ViewingVolumesOptions& options)
{
    return std::make_unique<ViewingVolumes>(options);
}

} // namespace oncollide
