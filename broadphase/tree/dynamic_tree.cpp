#include <oncollide/broadphase/tree/dynamic_tree.hpp>

#include <algorithm>

#include <oncollide/base/error.hpp>
#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/broadphase/aabb_checks.hpp>
#include <oncollide/broadphase/pair_sort.hpp>

namespace oncollide {

namespace {

constexpr std::size_t whole_share = 4;           // search everything if more than one body in this many changed
constexpr std::uint32_t worth_compacting = 1024; // slots
[[maybe_unused]] constexpr std::size_t always_validated = 4096;

} // namespace

void DynamicTree::rebuild(const BodyColumns& columns)
{
    std::vector<std::uint32_t> present;
    bodies_.list(present);
    tree_.build(columns.boxes.first(bodies_.rows()), present, options_.margin, threads_for_all());
    for (std::uint32_t body : gone_) bodies_.clear(body, BodyStates::held);
    for (std::uint32_t body : come_) bodies_.set(body, BodyStates::held);
    marked_version_ = unmarked;
    filter_.forget();
    loose_.clear();
}

/// Call after bodies got new places in the tree, or all of them if it was rebuilt.
void DynamicTree::note_places(bool rebuilt)
{
    marked_version_ = unmarked;
    if (rebuilt) filter_.forget(), loose_.clear();
}

/// Replaces loose AABBs in the tree by the bodies' own boxes.
void DynamicTree::refit(const BodyColumns& columns)
{
    tree_.refit(columns.boxes, options_.margin, threads_for_all());
    loose_.clear();
    if (tree_.degraded()) rebuild(columns);
}

void DynamicTree::take_in(const BodyColumns& columns)
{
    bodies_.check(columns);
    if (taken_in_) return;
    delimitation_.clear();
    delimited_ = false, whole_ = true;
    std::span<const std::uint32_t> moved = bodies_.changes();
    gone_.clear(), come_.clear();
    if (bodies_.some_came_or_went()) {
        moved_.clear();
        for (std::uint32_t body : bodies_.changes()) {
            const bool held = bodies_.is(body, BodyStates::held), present = contains(body);
            if (held && present) moved_.push_back(body);
            if (held && !present) gone_.push_back(body);
            if (!held && present) come_.push_back(body);
        }
        moved = moved_;
    }
    refuse_unusable(columns.boxes, come_);

    const std::size_t places = tree_.size() + come_.size() + 16;
    const bool fresh = come_.size() * 4 > size(); // appended leaves are not near their neighbours
    const bool sparse = places > worth_compacting && places > 2 * size();
    if (fresh || sparse || tree_.empty()) {
        rebuild(columns);
        note_escaped(moved);
    } else {
        tree_.erase(gone_);
        for (std::uint32_t body : gone_) bodies_.clear(body, BodyStates::held), loose_.erase(body);
        if (!come_.empty()) {
            note_places(tree_.append(columns.boxes.first(bodies_.rows()), come_, options_.margin, options_.threads));
            for (std::uint32_t body : come_) bodies_.set(body, BodyStates::held);
        }
        if (moved.size() * whole_share > size()) {
            refit(columns);
            note_escaped(moved);
        } else {
            loosen(columns, moved);
        }
    }
    note_escaped(come_);
    filter_.update(bodies_, escaped_, columns, tree_);
    filters_version_ = columns.filters_version;
    taken_in_ = true;
    ONCOLLIDE_ASSERT(tree_.bodies() == size());
}

/// Replaces the loose AABBs that `moved` bodies have left, also in the tree. A body that jumped out of its leaf gets a
/// place in a new leaf, because it would widen the old one too much.
void DynamicTree::loosen(const BodyColumns& columns, std::span<const std::uint32_t> moved)
{
    const bool filters_too = columns.filters_version == 0 || columns.filters_version != filters_version_;
    left_.clear();
    for (std::size_t k = 0; k < moved.size(); ++k) {
        if (constexpr std::size_t ahead = 8; k + ahead < moved.size())
            loose_.prefetch(moved[k + ahead], columns, filters_too);
        const bool dynamic = bodies_.is(moved[k], BodyStates::dynamic);
        if (!loose_.hold(moved[k], columns, dynamic, filters_too)) left_.push_back(moved[k]);
    }
    refuse_unusable(columns.boxes, left_);
    note_escaped(left_);
    jumped_.clear();
    std::erase_if(left_, [&](std::uint32_t body) {
        const bool jumps = tree_.outside_leaf(body, columns.boxes[body], options_.margin);
        if (jumps) jumped_.push_back(body);
        return jumps;
    });
    const auto renew = [&](std::uint32_t body) {
        return loose_.renew(body, columns, bodies_.is(body, BodyStates::dynamic));
    };
    tree_.refit_bodies(left_, renew, options_.margin);
    if (!jumped_.empty()) {
        for (std::uint32_t body : jumped_) loose_.erase(body);
        note_places(tree_.reinsert(columns.boxes.first(bodies_.rows()), jumped_, options_.margin, options_.threads));
    }
    constexpr double too_loose = 1.5; // higher than the default, because few queries search this tree
    if (tree_.degraded(too_loose)) refit(columns);
}

void DynamicTree::note_escaped(std::span<const std::uint32_t> bodies)
{
    for (std::uint32_t body : bodies)
        if (!bodies_.is(body, BodyStates::escaped)) {
            bodies_.set(body, BodyStates::escaped);
            escaped_.push_back(body);
        }
}

/// Selects the escaped bodies whose pairs must be searched for. A static body needs no query if every dynamic body is
/// queried.
void DynamicTree::collect_queries()
{
    for (std::uint32_t body : queries_) bodies_.clear(body, BodyStates::queried);
    queries_.clear();
    std::size_t dynamic = 0, is_static = 0; // numbers of escaped bodies
    for (std::uint32_t body : escaped_) {
        dynamic += bodies_.is(body, BodyStates::dynamic);
        is_static += bodies_.is(body, BodyStates::present) && !bodies_.is(body, BodyStates::dynamic);
    }
    const bool statics = dynamic < bodies_.dynamic_count();
    whole_ = (dynamic + (statics ? is_static : 0)) * whole_share > size();
    if (whole_) return;
    found_.clear();
    for (std::size_t k = 0; k < escaped_.size(); ++k) {
        constexpr std::size_t ahead = 16;
        if (k + ahead < escaped_.size()) tree_.prefetch_place_of(escaped_[k + ahead]);
        const std::uint32_t body = escaped_[k];
        if (bodies_.is(body, BodyStates::dynamic) || (statics && contains(body))) {
            found_.push_back({tree_.place_of(body), body});
            bodies_.set(body, BodyStates::queried);
        }
    }
    // Neighbours visit the same nodes: sort many queries in tree order.
    constexpr std::size_t worth_sorting = 4096;
    if (found_.size() >= worth_sorting) sort_pairs(found_, scratch_, tree_.size(), threads_for(found_.size()));
    for (const BodyPair& query : found_) queries_.push_back(query.b);
}

void DynamicTree::delimit(const BodyColumns& columns)
{
    take_in(columns);
    if (delimited_) return;
    collect_queries();
    if (!whole_) {
        const ForbiddingFilters filters = filter_.forbidding();
        constexpr std::size_t ahead = 8; // slots and bodies' data are scattered in memory
        for (std::size_t k = 0; k < queries_.size(); ++k) {
            if (k + ahead < queries_.size()) tree_.prefetch_box_at(found_[k + ahead].a);
            const std::uint32_t body = queries_[k];
            float box[6];
            tree_.box_at(found_[k].a, box); // see collect_queries()
            Delimitation::Filter filter;
            if (filters.layers) filter.layers = columns.layers[body], filter.mask = columns.masks[body];
            if (filters.groups) filter.group = forbidding_group(columns.groups[body]);
            delimitation_.add(box, filter);
        }
        ONCOLLIDE_ASSERT(found_.size() == queries_.size());
        delimitation_.run(tree_, filters.any(), threads_for(queries_.size()));
    }
    delimited_ = true;
}

/// Searches the whole tree.
/// @param changed_only  search for the pairs of changed bodies only; the other pairs stay as they are
void DynamicTree::find_whole(const BodyColumns& columns, bool changed_only)
{
    if (!loose_.empty()) {
        refit(columns);
        filter_.update(bodies_, escaped_, columns, tree_);
    }
    if (changed_only) {
        tree_.set_moving(bodies_.data(), BodyStates::changed);
        marked_version_ = unmarked;
    } else if (marked_version_ != bodies_.dynamic_version()) {
        tree_.set_moving(bodies_.data(), BodyStates::dynamic);
        marked_version_ = bodies_.dynamic_version();
    }
    std::vector<BodyPair>& found = changed_only ? found_ : pairs_;
    search_.find_pairs(tree_, columns, filter_.forbidding().any(), options_.margin, options_.threads, found);
    sort_pairs(found, scratch_, bodies_.rows(), threads_for_all());
    if (changed_only) replace_changed(pairs_, found_);
    near_.clear(), near_are_pairs_ = true;
}

/// True if a search for the pairs of changed bodies is worth while: no changed body is static, and an eighth of the
/// dynamic ones did not change.
bool DynamicTree::many_rest() const
{
    if (bodies_.changes().size() > bodies_.dynamic_count() - bodies_.dynamic_count() / 8) return false;
    return std::ranges::all_of(bodies_.changes(), [&](std::uint32_t body) {
        return bodies_.is(body, BodyStates::dynamic) || !contains(body);
    });
}

/// Finds all pairs that the queried bodies can form, given the boxes in the tree.
void DynamicTree::find_near(const BodyColumns& columns)
{
    const int threads = threads_for(queries_.size());
    const std::uint8_t* const states = bodies_.data();
    const bool filtered = filter_.forbidding().any();
    lists_.begin(found_, static_cast<int>(delimitation_.workers()));
    const auto keep = [&](std::size_t worker, const std::uint32_t* query, const std::uint32_t* place,
                          std::size_t count) {
        append_kept(
            lists_.of(worker), count,
            [&](std::size_t k) {
                constexpr std::size_t ahead = 8; // the bodies in these slots are scattered in memory
                if (k + 2 * ahead < count) tree_.prefetch_body_at(place[k + 2 * ahead]);
                if (k + ahead < count) prefetch(&states[tree_.body_at(place[k + ahead])]);
                return BodyPair{queries_[query[k]], tree_.body_at(place[k])};
            },
            [&](std::size_t, BodyPair& pair) {
                const auto [body, other] = pair;
                if (other == body || !((states[body] | states[other]) & BodyStates::dynamic)) return false;
                if (states[other] & BodyStates::queried && other < body) return false; // the other query finds it
                if (filtered && !columns.allows(body, other)) return false;
                if (body > other) pair = {other, body};
                return true;
            });
    };
    delimitation_.compare(tree_, threads, keep);
    lists_.join(found_);
    sort_pairs(found_, scratch_, bodies_.rows(), options_.threads);
}

/// Replaces the pairs of changed bodies in `list` by `by`. Both lists are sorted. Unchanged pairs are copied in runs.
void DynamicTree::replace_changed(std::vector<BodyPair>& list, const std::vector<BodyPair>& by)
{
    ONCOLLIDE_ASSERT(std::ranges::is_sorted(list) && std::ranges::is_sorted(by));
    scratch_.clear();
    auto next = by.begin();
    for (auto i = list.begin(); i != list.end();) {
        auto from = i;
        while (i != list.end() && !changed(*i)) ++i;
        for (; from != i; ++next) {
            const auto to = next == by.end() ? i : std::lower_bound(from, i, *next);
            scratch_.insert(scratch_.end(), from, to);
            from = to;
            if (from == i) break;
            scratch_.push_back(*next);
        }
        while (i != list.end() && changed(*i)) ++i;
    }
    scratch_.insert(scratch_.end(), next, by.end());
    list.swap(scratch_);
}

/// Replaces the pairs of escaped bodies in near_ by the pairs found; compares the boxes of all pairs in near_ with a
/// changed body.
void DynamicTree::compare_near(const BodyColumns& columns)
{
    if (near_are_pairs_) near_ = pairs_;
    near_are_pairs_ = false;
    scratch_.clear(), compared_.clear();
    for (const BodyPair pair : near_)
        if (changed(pair) && to_compare(pair)) scratch_.push_back(pair);
    compared_.resize(scratch_.size() + found_.size());
    std::ranges::merge(scratch_, found_, compared_.begin());
    found_.clear();
    for (std::size_t k = 0; k < compared_.size(); ++k) {
        if (constexpr std::size_t ahead = 8; k + ahead < compared_.size()) { // bodies are scattered in memory
            const BodyPair later = compared_[k + ahead];
            prefetch_all_of(columns.boxes[later.a]), prefetch_all_of(columns.boxes[later.b]);
        }
        const BodyPair pair = compared_[k];
        if (overlap(columns.boxes[pair.a], columns.boxes[pair.b], options_.margin)) found_.push_back(pair);
    }
    replace_changed(near_, compared_), replace_changed(pairs_, found_);
}

std::span<const BodyPair> DynamicTree::find_pairs(const BodyColumns& columns, bool whole)
{
    if (whole) {
        take_in(columns);
        delimitation_.clear();
        whole_ = true;
        find_whole(columns, false);
    } else {
        delimit(columns);
        if (!bodies_.changes().empty()) {
            if (whole_)
                find_whole(columns, many_rest());
            else
                find_near(columns), compare_near(columns);
        }
    }
    bodies_.forget_changes();
    for (std::uint32_t body : escaped_) bodies_.clear(body, BodyStates::escaped);
    escaped_.clear();
    loose_.end_frame();
    // A frame of a large tree with few changes takes less time than this.
    ONCOLLIDE_ASSERT_VALID(size() <= always_validated || loose_.frame() % 16 == 0 ? validate(columns) : "");
    return pairs_;
}

std::size_t DynamicTree::bytes() const
{
    const std::size_t lists = gone_.capacity() + come_.capacity() + moved_.capacity() + left_.capacity() +
                              jumped_.capacity() + escaped_.capacity() + queries_.capacity();
    const std::size_t pairs =
        near_.capacity() + pairs_.capacity() + found_.capacity() + scratch_.capacity() + compared_.capacity();
    return tree_.bytes() + bodies_.bytes() + search_.bytes() + delimitation_.bytes() + lists_.bytes() + loose_.bytes() +
           lists * sizeof(std::uint32_t) + pairs * sizeof(BodyPair);
}

std::unique_ptr<BroadPhase> make_kd_tree(const BroadPhase::Options& options)
{
    return std::make_unique<DynamicTree>("kd", AabbOrder::kd, options);
}
std::unique_ptr<BroadPhase> make_octree(const BroadPhase::Options& options)
{
    return std::make_unique<DynamicTree>("octree", AabbOrder::octree, options);
}

} // namespace oncollide
