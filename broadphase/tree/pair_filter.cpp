#include <oncollide/broadphase/tree/pair_filter.hpp>

#include <oncollide/base/error.hpp>

namespace oncollide {

void PairFilter::add(std::uint32_t body, const BodyColumns& columns)
{
    ONCOLLIDE_ASSERT(!with_layers_ || (body < columns.layers.size() && body < columns.masks.size()));
    ONCOLLIDE_ASSERT(!with_groups_ || body < columns.groups.size());
    if (with_layers_) {
        layers_ |= columns.layers[body], common_mask_ &= columns.masks[body];
        some_in_none_ |= columns.layers[body] == 0;
    }
    if (with_groups_) groups_ |= columns.groups[body] != 0;
}

void PairFilter::update(const BodyStates& bodies, std::span<const std::uint32_t> changed, const BodyColumns& columns,
                        AabbTree& tree)
{
    const bool layers = !columns.layers.empty(), groups = !columns.groups.empty();
    known_ = known_ && layers == with_layers_ && groups == with_groups_;
    const ForbiddingFilters of_tree = known_ ? forbidding() : ForbiddingFilters{};
    if (!known_) {
        *this = {};
        tree.forget_filters();
        known_ = true, with_layers_ = layers, with_groups_ = groups;
        if (layers || groups)
            for (std::uint32_t body = 0; body < bodies.rows(); ++body)
                if (bodies.is(body, BodyStates::present)) add(body, columns);
    } else if (layers || groups) {
        for (std::uint32_t body : changed)
            if (bodies.is(body, BodyStates::present)) {
                add(body, columns);
                if (of_tree.any()) tree.add_filters(body, columns);
            }
    }
    if (forbidding() != of_tree) tree.set_filters(columns, forbidding());
}

} // namespace oncollide
