// The potentially colliding set (PCS) of CULLIDE, and its fattened variant (FAR).
//
// A pass draws the list into a depth buffer, item after item. Before an item is drawn, an occlusion query counts its
// fragments at or behind the depth so far. If there is none, a surface in view direction separates the item from all
// before it. One pass in order and one in reverse compare each item with all others; an item that is fully visible in
// both leaves the set. Items are whole bodies, then subsets of their triangles; subsets of one body are not compared.
//
// Why `fattened` misses nothing: if two surfaces meet in a point q, the line of the nearest pixel centre is within
// sqrt(1/2) pixels of q, and within 0.8 with the snapping of corners to 1/16 pixel (GL_SUBPIXEL_BITS is at least 4).
// Both items draw boxes that contain the ball of one pixel around q, so on that line each has a fragment at least 0.6
// pixels behind q and one 0.6 pixels before it: both items are seen at or behind the other's depth. Float rounding of
// positions and depths is below 2^-20 of the view, at most 2^-10 pixels.
//
// Choices where the papers leave one open: the list holds the bodies of the broad phase's pairs; the view is the
// smallest cube around the items left, so that a pixel is equally large along all axes; an axis may certify the pass
// in order and another one the pass in reverse; passes repeat until the set stays the same, at most four times per
// level; a subset is a part of the triangles halved along the longest axis; in the end, a pair is left over if the
// boxes of two of its items overlap. FAR enlarges by sqrt(3)/2 pixels.
#include <oncollide/narrowphase/gl/culling/pair_culling.hpp>

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/gl/batch_clock.hpp>
#include <oncollide/narrowphase/gl/context.hpp>
#include <oncollide/narrowphase/gl/culling/culled_mesh.hpp>
#include <oncollide/narrowphase/gl/octant_queries.hpp>

namespace oncollide {

namespace {

constexpr int most_repeats = 4;

/// A body or a subset of its triangles.
struct Item {
    std::uint32_t body, first, count;
    Aabb box;                           ///< world
    bool before = false, after = false; ///< fully visible among the items before it, and among those after it
};

/// The box of a run at a pose, rounded outward.
Aabb placed(const Aabb& box, const Eigen::Isometry3d& pose)
{
    const Eigen::Vector3d centre = pose * box.centre();
    const Eigen::Vector3d half = pose.linear().cwiseAbs() * box.half_extent();
    const Eigen::Vector3d slack =
        Eigen::Vector3d::Constant(0x1p-48 * (centre.cwiseAbs() + half + box.centre().cwiseAbs()).maxCoeff());
    return {centre - half - slack, centre + half + slack};
}

class Cullide final : public PairCulling {
public:
    explicit Cullide(const CullideOptions& options)
        : options_(checked(options)), context_(options.gpu), view_(options.viewport, true),
          queries_(std::in_place, GL_ANY_SAMPLES_PASSED, 1024)
    {
        context_.check("setting up CULLIDE");
    }
    ~Cullide() override { context_.use_at_end(); }

    std::string name() const override
    {
        return fmt::format("CULLIDE ({} px{})", options_.viewport, options_.fattened ? ", fattened" : "");
    }
    std::string renderer() const override { return context_.info().renderer; }

    void attach(std::uint32_t number, const Mesh& mesh) override
    {
        context_.use();
        meshes_.erase(number);
        meshes_.try_emplace(number, mesh, static_cast<std::size_t>(options_.subset), options_.fattened);
        context_.check("copying a mesh to the GPU");
    }

    CullingWork cull(std::span<const CulledBody> bodies, std::span<const BodyPair> pairs,
                     std::span<std::uint8_t> left) override
    {
        context_.use();
        bodies_ = bodies, work_ = {};
        std::fill(left.begin(), left.end(), std::uint8_t{0});
        clock_.start();
        take_bodies(pairs);
        thin_out();
        take_subsets();
        thin_out();
        clock_.stop();
        for (std::size_t i = 0; i < pairs.size(); ++i) left[i] = may_collide(pairs[i]);
        work_.gpu_ms = clock_.ms();
        context_.check("the passes of CULLIDE");
        return work_;
    }

private:
    static CullideOptions checked(const CullideOptions& o)
    {
        if (o.viewport < 16 || o.viewport > 1024)
            throw Error(ErrorKind::usage,
                        fmt::format("CULLIDE: viewport is {} pixels; 16 to 1024 are valid", o.viewport));
        if (o.subset < 1)
            throw Error(ErrorKind::usage, fmt::format("CULLIDE: subsets of {} triangles; at least 1", o.subset));
        return o;
    }

    const gl::CulledMesh& mesh(std::uint32_t body) const { return meshes_.at(bodies_[body].mesh); }
    Item item(std::uint32_t body, const gl::CulledMesh::Run& run) const
    {
        return {body, run.first, run.count, placed(run.box, bodies_[body].pose)};
    }

    void take_bodies(std::span<const BodyPair> pairs)
    {
        std::vector<std::uint8_t> wanted(bodies_.size());
        for (const BodyPair pair : pairs) wanted[pair.a] = wanted[pair.b] = 1;
        items_.clear();
        for (std::uint32_t body = 0; body < wanted.size(); ++body)
            if (wanted[body]) items_.push_back(item(body, mesh(body).whole()));
    }

    void take_subsets()
    {
        std::vector<Item> subsets;
        for (const Item& whole : items_)
            for (const gl::CulledMesh::Run& run : mesh(whole.body).runs()) subsets.push_back(item(whole.body, run));
        items_ = std::move(subsets);
    }

    /// Repeats the passes until no item leaves the set.
    void thin_out()
    {
        for (int repeat = 0; repeat < most_repeats && !items_.empty(); ++repeat) {
            for (Item& each : items_) each.before = each.after = false;
            look_at_all();
            for (const int axis : {0, 1, 2}) run_passes(axis);
            if (std::erase_if(items_, [](const Item& each) { return each.before && each.after; }) == 0) return;
        }
    }

    /// A cube around all items, with room for their growth: 4 of viewport pixels on each side.
    void look_at_all()
    {
        Aabb all;
        for (const Item& each : items_) all.add(each.box);
        const double side = std::max((all.max - all.min).maxCoeff(), 1e-30) * (1 + 8.0 / (options_.viewport - 8));
        view_.look_at(all.centre(), Eigen::Vector3d::Constant(side / 2));
        growth_ = options_.fattened ? side / options_.viewport : 0;
    }

    /// Both passes along an axis, for the items that no earlier axis has certified.
    void run_passes(int axis)
    {
        asked_.clear();
        if (queries_->size() < 2 * items_.size()) queries_.emplace(GL_ANY_SAMPLES_PASSED, 4 * items_.size());
        view_.look_along(axis);
        view_.clear_depth();
        for (std::size_t begin = 0, end; begin < items_.size(); begin = end) {
            for (end = begin; end < items_.size() && items_[end].body == items_[begin].body;) ++end;
            pass(begin, end, &Item::before);
        }
        view_.clear_depth();
        for (std::size_t end = items_.size(), begin; end > 0; end = begin) {
            for (begin = end; begin > 0 && items_[begin - 1].body == items_[end - 1].body;) --begin;
            pass(begin, end, &Item::after);
        }
        const std::span<const GLuint> seen = queries_->read(asked_.size());
        for (std::size_t i = 0; i < asked_.size(); ++i) *asked_[i] |= seen[i] == 0;
        work_.queries += asked_.size();
    }

    /// Compares the items of one body with the depth so far, then adds them to it.
    void pass(std::size_t begin, std::size_t end, bool Item::*certified)
    {
        const gl::CulledMesh& drawn = mesh(items_[begin].body);
        view_.place(drawn, bodies_[items_[begin].body].pose, growth_);
        glDepthMask(GL_FALSE), glDepthFunc(GL_GEQUAL);
        for (std::size_t i = begin; i < end; ++i) {
            if (items_[i].*certified) continue;
            glBeginQuery(GL_ANY_SAMPLES_PASSED, (*queries_)[asked_.size()]);
            drawn.draw(items_[i].first, items_[i].count);
            glEndQuery(GL_ANY_SAMPLES_PASSED);
            asked_.push_back(&(items_[i].*certified));
        }
        glDepthMask(GL_TRUE), glDepthFunc(GL_LESS);
        for (std::size_t i = begin, last; i < end; i = last) { // draws consecutive runs in one call
            std::uint32_t count = 0;
            for (last = i; last < end && items_[last].first == items_[i].first + count;) count += items_[last++].count;
            drawn.draw(items_[i].first, count);
        }
    }

    bool may_collide(BodyPair pair) const
    {
        const auto of = [&](std::uint32_t body) { return std::ranges::equal_range(items_, body, {}, &Item::body); };
        for (const Item& a : of(pair.a))
            for (const Item& b : of(pair.b))
                if (a.box.overlaps(b.box)) return true;
        return false;
    }

    CullideOptions options_;
    gl::Context context_; ///< comes first, because all members below live in this context
    gl::CullingView view_;
    std::optional<gl::Queries> queries_; ///< replaced when more queries are needed
    gl::BatchClock clock_;
    std::map<std::uint32_t, gl::CulledMesh> meshes_;

    // The current call.
    std::span<const CulledBody> bodies_;
    std::vector<Item> items_;  ///< the set, by body
    std::vector<bool*> asked_; ///< by query: the result that it certifies
    double growth_ = 0;        ///< metres
    CullingWork work_;
};

} // namespace

std::unique_ptr<PairCulling> make_cullide(const CullideOptions& options)
{
    return std::make_unique<Cullide>(options);
}

} // namespace oncollide
