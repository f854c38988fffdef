#include <oncollide/broadphase/body_states.hpp>

#include <algorithm>
#include <string>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/box_checks.hpp>

namespace oncollide {

namespace {

std::string the_body(std::size_t body)
{
    std::string text = "body ";
    return text += std::to_string(body);
}

} // namespace

void BodyStates::require(std::span<const std::uint32_t> bodies, bool there) const
{
    if (there && !bodies.empty() && std::ranges::max(bodies) < rows()) { // the usual case, without a branch per body
        std::uint8_t common = present;
        for (std::uint32_t body : bodies) common &= states_[body];
        if (common) return;
    }
    for (std::uint32_t body : bodies)
        if (is(body, present) != there)
            throw Error(ErrorKind::usage,
                        the_body(body) + (there ? ": is not in the broad phase" : ": is in the broad phase"));
}

void BodyStates::mark_changed(std::span<const std::uint32_t> bodies)
{
    const std::size_t before = changes_.size();
    if (changes_.capacity() < before + bodies.size()) changes_.reserve(std::max(before + bodies.size(), 2 * before));
    changes_.resize(before + bodies.size());
    std::uint32_t* out = changes_.data() + before;
    std::uint8_t* const states = states_.data(); // bytes may alias everything
    for (std::uint32_t body : bodies) {
        *out = body;
        out += !(states[body] & changed);
        states[body] |= changed;
    }
    changes_.resize(static_cast<std::size_t>(out - changes_.data()));
}

inline void BodyStates::set_awake(std::uint32_t body, bool now)
{
    if (is(body, awake) == now) return;
    states_[body] ^= awake;
    now ? ++awake_count_ : --awake_count_;
    ++awake_version_;
}

void BodyStates::add(std::span<const std::uint32_t> bodies, bool asleep)
{
    require(bodies, false);
    if (bodies.empty()) return;
    if (const std::size_t largest = std::ranges::max(bodies); largest >= states_.size()) states_.resize(largest + 1);
    mark_changed(bodies);
    for (std::uint32_t body : bodies) {
        set(body, present);
        set_awake(body, !asleep);
    }
    size_ += bodies.size();
    came_or_went_ = true;
}

void BodyStates::remove(std::span<const std::uint32_t> bodies)
{
    require(bodies, true);
    mark_changed(bodies);
    for (std::uint32_t body : bodies) {
        set_awake(body, false);
        clear(body, present);
    }
    size_ -= bodies.size();
    came_or_went_ |= !bodies.empty();
}

void BodyStates::move(std::span<const std::uint32_t> bodies)
{
    require(bodies, true);
    mark_changed(bodies);
}

void BodyStates::set_awake(std::span<const std::uint32_t> bodies, bool now)
{
    require(bodies, true);
    mark_changed(bodies);
    for (std::uint32_t body : bodies) set_awake(body, now);
}

void BodyStates::check(const BodyColumns& columns) const
{
    const auto short_of = [&](std::size_t rows) { return rows < states_.size(); };
    if (short_of(columns.boxes.size()) || columns.layers.size() != columns.masks.size() ||
        (!columns.layers.empty() && short_of(columns.layers.size())) ||
        (!columns.groups.empty() && short_of(columns.groups.size())))
        throw Error(ErrorKind::usage, "columns end before " + the_body(states_.empty() ? 0 : states_.size() - 1));
}

void BodyStates::forget_changes()
{
    if (changes_.size() * 4 > states_.size())
        for (std::uint8_t& state : states_) state &= static_cast<std::uint8_t>(~changed);
    else
        for (std::uint32_t body : changes_) clear(body, changed);
    changes_.clear();
    came_or_went_ = false;
}

void BodyStates::list(std::vector<std::uint32_t>& bodies) const
{
    bodies.clear();
    for (std::uint32_t body = 0; body < rows(); ++body)
        if (states_[body] & present) bodies.push_back(body);
}

TracksBodies::TracksBodies(const Options& options) : options_(options)
{
    if (!(options.margin >= 0 && options.margin <= 1e15) || options.threads < 1)
        throw Error(ErrorKind::usage, "broad phase: margin must be from 0 to 1e15 m, threads 1 or more");
}

void TracksBodies::check_query(const BodyColumns& columns, std::span<const Aabb> boxes) const
{
    bodies_.check(columns);
    if (!taken_in_) throw Error(ErrorKind::usage, "broad phase: query() before take_in() of the changes");
    refuse_unusable_queries(boxes);
}

} // namespace oncollide
