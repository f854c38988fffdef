#include <oncollide/broadphase/dynamic_tree.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/delimitation.hpp>
#include <oncollide/broadphase/pair_sort.hpp>

namespace oncollide {

namespace {

std::string the_body(std::uint32_t body)
{
    std::string text = "body ";
    return text += std::to_string(body);
}

constexpr int everything = 4;                    // where more than one in so many changed, all is searched
constexpr std::uint32_t worth_compacting = 1024; // places

enum State : std::uint8_t {
    present = 1,
    awake = 2,
    in_tree = 4,
    moved = 8,    // its box is to be taken in
    changed = 16, // what is known of its pairs is out of date
    asking = 32,  // is among those asked for
};

} // namespace

struct DynamicTree::Impl {
    Options options;
    BoxTree tree{BoxOrder::kd};
    TreeSearch search;
    Delimitation delimitation, question;
    std::vector<std::uint8_t> state;                     ///< by body
    std::vector<std::uint8_t> asleep;                    ///< by body, for the filter
    std::vector<std::uint32_t> gone, come, moved_bodies; ///< scratch: bodies for the tree to change
    std::vector<std::uint32_t> changes;                  ///< bodies with state `moved` or `changed`, each once
    std::vector<std::uint32_t> asked;                    ///< of the changed ones, those to be asked for
    std::vector<BodyPair> kept;                          ///< pairs of the boxes as the tree holds them
    std::vector<BodyPair> exact; ///< of these, pairs of the boxes themselves; only where they may differ
    std::vector<BodyPair> found, scratch;
    std::vector<std::uint32_t> any; ///< layers and masks, where there are none
    std::size_t size = 0, awake_count = 0;
    bool taken_in = false;     ///< are all changes in the tree?
    bool delimited = false;    ///< has delimit() run since?
    bool search_all = true;    ///< must the whole tree be searched?
    bool moving_known = false; ///< are the tree's moving marks up to date?
    bool layers_known = false; ///< does the tree know all layers, where they forbid anything?
    bool kept_stale = false;   ///< are all kept pairs out of date, not those of changed bodies alone?
    LayerSummary layers;       ///< of all bodies, at least

    double tree_margin() const { return options.margin + options.fat; }
    int threads_for(std::size_t count) const { return count < TreeSearch::worth_threads / 8 ? 1 : options.threads; }

    BodyFilter filter(const BodyColumns& columns)
    {
        if (columns.boxes.size() < state.size() || columns.layers.size() != columns.masks.size() ||
            (!columns.layers.empty() && columns.layers.size() < state.size()))
            throw Error(ErrorKind::usage,
                        "columns end before " + the_body(static_cast<std::uint32_t>(state.size() - 1)));
        if (!columns.layers.empty()) return {asleep, columns.layers, columns.masks};
        any.resize(state.size(), ~0u);
        return {asleep, any, any};
    }

    void touch(std::uint32_t body, std::uint8_t how)
    {
        if (!(state[body] & (moved | changed))) changes.push_back(body);
        state[body] |= how;
        taken_in = delimited = false;
    }

    template <class Change>
    void change(std::span<const std::uint32_t> list, bool there, Change apply)
    {
        for (std::uint32_t body : list) {
            const bool is_there = body < state.size() && (state[body] & present);
            if (is_there != there)
                throw Error(ErrorKind::usage, the_body(body) + (there ? ": is not in the tree" : ": is in the tree"));
        }
        for (std::uint32_t body : list) apply(body);
    }

    void set_awake(std::uint32_t body, bool now)
    {
        if (bool(state[body] & awake) == now) return;
        state[body] = static_cast<std::uint8_t>(now ? state[body] | awake : state[body] & ~awake);
        asleep[body] = !now;
        now ? ++awake_count : --awake_count;
        moving_known = false;
    }

    void take_in(const BodyColumns& columns, const BodyFilter& filter);
    void rebuild(const BodyColumns& columns);
    void refit(const BodyColumns& columns);
    bool stays_inside(std::uint32_t body, const Aabb& box) const;
    void learn_layers(const BodyFilter& filter);
    void collect_asked();
    void delimit(const BodyColumns& columns);
    void update(const BodyColumns& columns, const BodyFilter& filter);
    void find_changed(const BodyColumns& columns, const BodyFilter& filter);
    std::span<const BodyPair> find_pairs(const BodyColumns& columns);
};

DynamicTree::DynamicTree() : DynamicTree(Options{}) {}
DynamicTree::DynamicTree(const Options& options) : impl_(std::make_unique<Impl>())
{
    const auto usable = [](double x) { return x >= 0 && x <= 1e15; };
    if (!usable(options.margin) || !usable(options.fat) || options.threads < 1)
        throw Error(ErrorKind::usage, "DynamicTree: margin and fat must be from 0 to 1e15 m, threads 1 or more");
    impl_->options = options;
}
DynamicTree::~DynamicTree() = default;
DynamicTree::DynamicTree(DynamicTree&&) noexcept = default;
DynamicTree& DynamicTree::operator=(DynamicTree&&) noexcept = default;

void DynamicTree::add(std::span<const std::uint32_t> bodies, bool asleep)
{
    Impl& p = *impl_;
    p.change(bodies, false, [&](std::uint32_t body) {
        if (body >= p.state.size()) p.state.resize(body + std::size_t{1}), p.asleep.resize(body + std::size_t{1}, 1);
        p.touch(body, present | moved | changed);
        p.set_awake(body, !asleep);
        ++p.size;
    });
}
void DynamicTree::remove(std::span<const std::uint32_t> bodies)
{
    Impl& p = *impl_;
    p.change(bodies, true, [&](std::uint32_t body) {
        p.touch(body, changed);
        p.set_awake(body, false);
        p.state[body] &= static_cast<std::uint8_t>(~present);
        --p.size;
    });
}
void DynamicTree::move(std::span<const std::uint32_t> bodies)
{
    impl_->change(bodies, true, [&](std::uint32_t body) { impl_->touch(body, moved); });
}
void DynamicTree::sleep(std::span<const std::uint32_t> bodies)
{
    impl_->change(bodies, true, [&](std::uint32_t body) {
        impl_->touch(body, changed);
        impl_->set_awake(body, false);
    });
}
void DynamicTree::wake(std::span<const std::uint32_t> bodies)
{
    impl_->change(bodies, true, [&](std::uint32_t body) {
        impl_->touch(body, changed);
        impl_->set_awake(body, true);
    });
}

/// Is a body's new box inside the larger one that the tree holds of it?
bool DynamicTree::Impl::stays_inside(std::uint32_t body, const Aabb& box) const
{
    if (options.fat == 0) return false;
    float now[6], held[6];
    tree.round(box, options.margin, now);
    tree.box_at(tree.place_of(body), held);
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) inside &= (now[axis] >= held[axis]) & (now[3 + axis] <= held[3 + axis]);
    return inside;
}

void DynamicTree::Impl::rebuild(const BodyColumns& columns)
{
    std::vector<std::uint32_t> bodies;
    for (std::uint32_t body = 0; body < state.size(); ++body)
        if (state[body] & present) bodies.push_back(body);
    tree.build(columns.boxes, bodies, tree_margin(), bodies.size() < TreeSearch::worth_threads ? 1 : options.threads);
    for (std::uint8_t& s : state) s = static_cast<std::uint8_t>(s & present ? s | in_tree : s & ~in_tree);
    moving_known = layers_known = false;
    kept_stale = options.fat > 0;
}

/// Every box of the tree follows its body again.
void DynamicTree::Impl::refit(const BodyColumns& columns)
{
    tree.refit(columns.boxes, tree_margin(), options.threads);
    kept_stale = options.fat > 0;
}

/// Brings the tree up to date. `changed` then marks the bodies whose pairs are to be found anew.
void DynamicTree::Impl::take_in(const BodyColumns& columns, const BodyFilter& filter)
{
    if (taken_in) return;
    delimitation.clear();
    gone.clear(), come.clear(), moved_bodies.clear();
    for (std::uint32_t body : changes) {
        const std::uint8_t s = state[body];
        if (!(s & present)) {
            if (s & in_tree) gone.push_back(body);
        } else if (!(s & in_tree)) {
            come.push_back(body);
        } else if (s & moved && !stays_inside(body, columns.boxes[body])) {
            moved_bodies.push_back(body), state[body] |= changed;
        }
    }
    refuse_unusable(columns.boxes, come);

    const std::size_t places = tree.size() + come.size() + 16;
    const bool fresh = come.size() * 4 > size; // what is appended lies apart from its neighbours
    const bool sparse = places > worth_compacting && places > 2 * size;
    if (fresh || sparse || tree.empty()) {
        rebuild(columns);
    } else {
        tree.erase(gone);
        if (!come.empty()) {
            tree.append(columns.boxes, come, tree_margin(), options.threads);
            moving_known = layers_known = false;
        }
        for (std::uint32_t body : gone) state[body] &= static_cast<std::uint8_t>(~in_tree);
        for (std::uint32_t body : come) state[body] |= in_tree;
        if (moved_bodies.size() * everything > size)
            refit(columns);
        else
            tree.refit_bodies(columns.boxes, tree_margin(), moved_bodies);
        if (tree.degraded()) refit(columns);
        if (tree.degraded()) rebuild(columns);
    }
    std::erase_if(changes, [&](std::uint32_t body) {
        state[body] &= static_cast<std::uint8_t>(~moved);
        return !(state[body] & changed);
    });
    learn_layers(filter);
    taken_in = true;
}

/// The tree knows layers only where they forbid something; it forgets them when it is built.
void DynamicTree::Impl::learn_layers(const BodyFilter& filter)
{
    if (!layers_known) layers = LayerSummary(filter);
    const bool knew = layers_known && !layers.allow_all();
    for (std::uint32_t body : changes)
        if (state[body] & present) {
            layers.add(filter.layers[body], filter.masks[body]);
            if (knew) tree.add_layers(body, filter);
        }
    if (!knew && !layers.allow_all()) tree.set_layers(filter);
    layers_known = true;
}

/// Bodies to be asked for: those that changed. A pair of a sleeper with one that is awake is found from that one, if it
/// changed too.
void DynamicTree::Impl::collect_asked()
{
    for (std::uint32_t body : asked) state[body] &= static_cast<std::uint8_t>(~asking);
    asked.clear();
    std::size_t awake_changed = 0;
    for (std::uint32_t body : changes) awake_changed += (state[body] & awake) != 0;
    for (std::uint32_t body : changes)
        if (state[body] & awake || (state[body] & present && awake_changed < awake_count)) {
            asked.push_back(body);
            state[body] |= asking;
        }
}

void DynamicTree::Impl::delimit(const BodyColumns& columns)
{
    const BodyFilter allowed = filter(columns);
    take_in(columns, allowed);
    if (delimited) return;
    collect_asked();
    search_all = kept_stale || asked.size() * everything > size;
    if (!search_all) {
        for (std::uint32_t body : asked) {
            float box[6];
            tree.box_at(tree.place_of(body), box);
            delimitation.ask(box, allowed.layers[body], allowed.masks[body]);
        }
        delimitation.run(tree, !layers.allow_all(), threads_for(asked.size()));
    }
    delimited = true;
}

/// The pairs of the bodies asked for replace what was known of those that changed.
void DynamicTree::Impl::find_changed(const BodyColumns& columns, const BodyFilter& allowed)
{
    found.clear();
    for (const auto& list : delimitation.compare(tree, threads_for(asked.size())))
        for (std::size_t k = 0; k < list->size(); ++k) {
            constexpr std::size_t ahead = 8; // what the places found point to lies scattered in memory
            if (k + 2 * ahead < list->size()) tree.prefetch_body_at(list->j(k + 2 * ahead));
            if (k + ahead < list->size()) __builtin_prefetch(&state[tree.body_at(list->j(k + ahead))]);
            const std::uint32_t body = asked[list->i(k)], place = list->j(k), other = tree.body_at(place);
            if (other == body || !((state[body] | state[other]) & awake)) continue;
            if (state[other] & asking && other < body) continue; // that one finds the pair
            if (!layers.allow_all() && !allowed.allows(body, other)) continue;
            if (options.fat > 0 || tree.surely_overlap(place, delimitation.box(list->i(k))) ||
                overlap(columns.boxes[body], columns.boxes[other], options.margin))
                found.push_back({std::min(body, other), std::max(body, other)});
        }
    sort_pairs(found, scratch, state.size(), options.threads);
    std::erase_if(kept, [&](BodyPair p) { return (state[p.a] | state[p.b]) & changed; });
    if (found.empty()) return;
    scratch.resize(kept.size() + found.size());
    std::ranges::merge(kept, found, scratch.begin());
    kept.swap(scratch);
}

std::span<const BodyPair> DynamicTree::Impl::find_pairs(const BodyColumns& columns)
{
    delimit(columns);
    const BodyFilter allowed = filter(columns);
    if (search_all && (kept_stale || !changes.empty())) {
        if (!moving_known) tree.set_moving(asleep), moving_known = true;
        search.find_pairs(tree, columns.boxes, allowed, options.margin, options.fat == 0, options.threads, kept);
        sort_pairs(kept, scratch, state.size(), options.threads);
        kept_stale = false;
    } else if (!changes.empty()) {
        find_changed(columns, allowed);
    }
    for (std::uint32_t body : changes) state[body] &= static_cast<std::uint8_t>(~changed);
    changes.clear();
    if (options.fat == 0) return kept;
    exact.clear();
    for (BodyPair p : kept)
        if (overlap(columns.boxes[p.a], columns.boxes[p.b], options.margin)) exact.push_back(p);
    return exact;
}

void DynamicTree::delimit(const BodyColumns& columns)
{
    impl_->delimit(columns);
}
std::span<const BodyPair> DynamicTree::find_pairs(const BodyColumns& columns)
{
    return impl_->find_pairs(columns);
}
std::span<const DelimitationLevel> DynamicTree::levels()
{
    if (impl_->search_all) return {};
    return impl_->delimitation.levels(impl_->tree);
}
std::uint64_t DynamicTree::bodies_left()
{
    return impl_->search_all ? impl_->size : impl_->delimitation.bodies_left(impl_->tree);
}
void DynamicTree::survivors(std::vector<std::uint32_t>& bodies)
{
    if (!impl_->search_all) return impl_->delimitation.survivors(impl_->tree, bodies);
    bodies.clear();
    for (std::uint32_t body = 0; body < impl_->state.size(); ++body)
        if (contains(body)) bodies.push_back(body);
}

void DynamicTree::query(const BodyColumns& columns, std::span<const Aabb> boxes, std::vector<BoxHit>& hits)
{
    Impl& p = *impl_;
    p.take_in(columns, p.filter(columns));
    hits.clear();
    p.question.clear();
    for (std::uint32_t k = 0; k < boxes.size(); ++k) {
        if (!(boxes[k].min.cwiseAbs().sum() + boxes[k].max.cwiseAbs().sum() < 1e30))
            throw Error(ErrorKind::bad_data,
                        std::string("query ").append(std::to_string(k)) + ": the box is not finite, or beyond 1e30 m");
        float box[6];
        p.tree.round(boxes[k], p.options.margin, box);
        p.question.ask(box, ~0u, ~0u);
    }
    const int threads = p.threads_for(boxes.size());
    p.question.run(p.tree, false, threads);
    for (const auto& list : p.question.compare(p.tree, threads))
        for (std::size_t k = 0; k < list->size(); ++k) {
            const BoxHit hit{list->i(k), p.tree.body_at(list->j(k))};
            if (overlap(boxes[hit.query], columns.boxes[hit.body], p.options.margin)) hits.push_back(hit);
        }
    std::sort(hits.begin(), hits.end());
}

std::size_t DynamicTree::size() const
{
    return impl_->size;
}
bool DynamicTree::contains(std::uint32_t body) const
{
    return body < impl_->state.size() && impl_->state[body] & present;
}
std::size_t DynamicTree::bytes() const
{
    const Impl& p = *impl_;
    return p.tree.bytes() + p.search.bytes() + p.delimitation.bytes() + p.question.bytes() + p.state.capacity() +
           p.asleep.capacity() +
           (p.changes.capacity() + p.asked.capacity() + p.any.capacity() + p.gone.capacity() + p.come.capacity() +
            p.moved_bodies.capacity()) *
               sizeof(std::uint32_t) +
           (p.kept.capacity() + p.exact.capacity() + p.found.capacity() + p.scratch.capacity()) * sizeof(BodyPair);
}

} // namespace oncollide
