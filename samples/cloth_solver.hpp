// A small cloth by position-based dynamics that never passes through anything: an example, and the instrument of tests.
// The World's near features are its contacts, and bound how far each vertex may move in a step. Source: Mueller et al.,
// "Position based dynamics", 2007; the bound of the steps as in Wu, Wang and Wang, "A safe and fast repulsion method
// for GPU-based cloth self collisions", 2020.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <oncollide/pipeline/world.hpp>

namespace oncollide::example {

class ClothSolver {
public:
    double dt = 0.005;
    double thickness = 0.002; ///< metres: the distance that contacts keep
    double reach = 0.006;     ///< metres: features that are nearer are contacts; above the thickness
    double friction = 0.5, drag = 3, bending = 0.1; ///< drag: share of the velocity lost in a second
    double damping = 0.6; ///< share of the difference of two neighbours' velocities lost in a step
    int iterations = 20;
    Eigen::Vector3d gravity{0, 0, -9.81};

    /// @param cloth   a body at the identity, which stays there; the vertices of its model, a mesh in memory, move
    /// @param others  bodies that do not move
    ClothSolver(World& world, BodyId cloth, std::vector<BodyId> others)
        : world_(world), cloth_(cloth), model_(world.bodies().model(cloth)), others_(std::move(others)),
          triangles_(mesh().triangles), x_(mesh().vertices), p_(x_), v_(x_.size(), Eigen::Vector3d::Zero()),
          most_(x_.size())
    {
        std::map<std::array<std::uint32_t, 2>, std::uint32_t>
            opposite; // by edge: the third corner of its first triangle
        const auto link = [&](std::uint32_t a, std::uint32_t b, double stiffness) {
            links_.push_back({a, b, (x_[a] - x_[b]).norm(), stiffness});
        };
        for (const Triangle& t : triangles_)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
                const auto [at, is_new] = opposite.try_emplace({a, b}, t[(k + 2) % 3]);
                is_new ? link(a, b, 1) : link(at->second, t[(k + 2) % 3], bending);
            }
    }

    /// Moves the cloth by dt. Before and after it, nothing crosses the cloth.
    void step()
    {
        find_contacts();
        for (std::size_t i = 0; i < x_.size(); ++i) {
            v_[i] = (1 - drag * dt) * (v_[i] + dt * gravity);
            p_[i] = x_[i] + dt * v_[i];
        }
        for (int k = 0; k < iterations; ++k) {
            for (const Link& link : links_) hold(link);
            for (const Contact& contact : contacts_) keep_apart(contact);
        }
        for (std::size_t i = 0; i < x_.size(); ++i) {
            const Eigen::Vector3d way = p_[i] - x_[i];
            const double length = way.norm(), share = length > most_[i] ? most_[i] / length : 1;
            x_[i] += share * way, v_[i] = share / dt * way;
        }
        for (const Link& link : links_) { // neighbours move alike
            const Eigen::Vector3d more = 0.5 * damping * link.stiffness * (v_[link.b] - v_[link.a]);
            v_[link.a] += more, v_[link.b] -= more;
        }
        world_.models().set_vertices(model_, x_);
    }
    std::size_t contacts() const { return contacts_.size(); }
    double fastest() const ///< m/s
    {
        double most = 0;
        for (const Eigen::Vector3d& v : v_) most = std::max(most, v.norm());
        return most;
    }
    const std::vector<Eigen::Vector3d>& positions() const { return x_; }

private:
    struct Link {
        std::uint32_t a, b;
        double length, stiffness;
    };
    /// A point of the cloth, as a mean of its vertices.
    struct Place {
        std::size_t count = 0;
        std::array<std::uint32_t, 3> vertex{};
        std::array<double, 3> weight{};
    };
    /// Two points that must stay apart along a direction; the second is of another body, `there`, or of the cloth.
    struct Contact {
        Place first, second;
        Eigen::Vector3d there, normal; ///< normal: from the second point to the first
        double least;                  ///< metres: the distance that they keep
    };

    const Mesh& mesh() const { return std::get<Mesh>(world_.models().geometry(model_).data); }
    void find_contacts()
    {
        // Two features move at most 0.9 of their distance towards each other, so none passes another. Features that are
        // not near are more than `reach` apart.
        constexpr double share = 0.45;
        std::fill(most_.begin(), most_.end(), share * reach);
        contacts_.clear();
        const auto add = [&](const NearFeatures& f, bool both) {
            Contact c{place(f.a, f.point_a), both ? place(f.b, f.point_b) : Place{}, f.point_b, f.point_a - f.point_b,
                      thickness};
            for (const Place* of : {&c.first, &c.second})
                for (std::size_t k = 0; k < of->count; ++k)
                    most_[of->vertex[k]] = std::min(most_[of->vertex[k]], share * f.lower);
            c.normal.normalize();
            if (f.upper < thickness)
                c.least = 0.9 * f.upper + 0.1 * thickness; // pushed out slowly: the cloth must rest
            contacts_.push_back(c);
        };
        for (const BodyId other : others_)
            for (const NearFeatures& f : world_.pairs().near_features(cloth_, other, reach)) add(f, false);
        for (const NearFeatures& f : world_.models().near_features(model_, reach)) add(f, true);
    }
    Place place(FeatureBits feature, const Eigen::Vector3d& at) const
    {
        if (kind_of(feature) == FeatureKind::vertex) return {1, {static_cast<std::uint32_t>(number_of(feature))}, {1}};
        if (kind_of(feature) == FeatureKind::edge) {
            const auto [a, b] = edge_vertices(feature);
            const Eigen::Vector3d d = x_[b] - x_[a];
            const double t = std::clamp(d.dot(at - x_[a]) / d.squaredNorm(), 0.0, 1.0);
            return {2, {a, b}, {1 - t, t}};
        }
        const Triangle& t = triangles_[number_of(feature)];
        const Eigen::Vector3d u = x_[t[1]] - x_[t[0]], v = x_[t[2]] - x_[t[0]], n = u.cross(v), w = at - x_[t[0]];
        const double second = w.cross(v).dot(n) / n.squaredNorm(), third = u.cross(w).dot(n) / n.squaredNorm();
        return {3, {t[0], t[1], t[2]}, {1 - second - third, second, third}};
    }
    void hold(const Link& link)
    {
        const Eigen::Vector3d d = p_[link.b] - p_[link.a];
        const double length = d.norm();
        if (!(length > 0)) return;
        const Eigen::Vector3d move = 0.5 * link.stiffness * (1 - link.length / length) * d;
        p_[link.a] += move, p_[link.b] -= move;
    }
    /// The mean of the vertices' positions, or of their motion in this step.
    Eigen::Vector3d mean(const Place& of, bool motion) const
    {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < of.count; ++k)
            sum += of.weight[k] * (motion ? Eigen::Vector3d(p_[of.vertex[k]] - x_[of.vertex[k]]) : p_[of.vertex[k]]);
        return sum;
    }
    void keep_apart(const Contact& c)
    {
        const Eigen::Vector3d second = c.second.count ? mean(c.second, false) : c.there;
        const double deep = c.least - c.normal.dot(mean(c.first, false) - second);
        if (!(deep > 0)) return;
        Eigen::Vector3d slide = mean(c.first, true) - mean(c.second, true);
        slide -= c.normal.dot(slide) * c.normal;
        const double length = slide.norm();
        const Eigen::Vector3d move =
            deep * c.normal - (length > 0 ? std::min(1.0, friction * deep / length) : 0) * slide;
        double sum = 0;
        for (const Place* of : {&c.first, &c.second})
            for (std::size_t k = 0; k < of->count; ++k) sum += of->weight[k] * of->weight[k];
        for (std::size_t k = 0; k < c.first.count; ++k) p_[c.first.vertex[k]] += c.first.weight[k] / sum * move;
        for (std::size_t k = 0; k < c.second.count; ++k) p_[c.second.vertex[k]] -= c.second.weight[k] / sum * move;
    }

    World& world_;
    const BodyId cloth_;
    const ModelId model_;
    const std::vector<BodyId> others_;
    const std::vector<Triangle> triangles_;
    std::vector<Eigen::Vector3d> x_, p_, v_; ///< positions before and after the step, velocities
    std::vector<double> most_;               ///< metres: how far each vertex may move in the step
    std::vector<Link> links_;
    std::vector<Contact> contacts_;
};

} // namespace oncollide::example
