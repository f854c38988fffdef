#include <oncollide/broadphase/body_states.hpp>

#include <algorithm>
#include <string>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/aabb_checks.hpp>

namespace oncollide {

namespace {

std::string the_body(std::size_t body)
{
    std::string text = "body ";
    return text += std::to_string(body);
}

/// Calls work(chunk) for consecutive chunks of a list until it returns false. Returns the last call's result. A chunk
/// stays in the cache while several branch-free or vectorised loops process it: all bodies may move in every frame.
template <class Work>
bool in_chunks(std::span<const std::uint32_t> list, Work work)
{
    constexpr std::size_t chunk = 1024;
    bool go_on = true;
    for (std::size_t k = 0; k < list.size() && go_on; k += chunk)
        go_on = work(list.subspan(k, std::min(chunk, list.size() - k)));
    return go_on;
}

/// True if each number is the previous one plus 1.
bool is_run(std::span<const std::uint32_t> list)
{
    std::uint32_t wrong = 0;
    for (std::uint32_t k = 0; k < list.size(); ++k) wrong |= list[k] ^ (list[0] + k);
    return wrong == 0;
}

} // namespace

bool BodyStates::all_present(std::span<const std::uint32_t> bodies) const
{
    return in_chunks(bodies, [&](std::span<const std::uint32_t> some) {
        std::uint8_t common = present;
        std::uint32_t largest = 0;
        for (std::uint32_t body : some) largest = std::max(largest, body);
        if (largest >= rows()) return false;
        if (is_run(some))
            for (std::size_t k = 0; k < some.size(); ++k) common &= states_[some[0] + k];
        else
            for (std::uint32_t body : some) common &= states_[body];
        return common != 0;
    });
}

void BodyStates::require(std::span<const std::uint32_t> bodies, bool there) const
{
    if (there && all_present(bodies)) return;
    for (std::uint32_t body : bodies)
        if (is(body, present) != there)
            throw Error(ErrorKind::usage,
                        the_body(body) + (there ? ": is not in the broad phase" : ": is in the broad phase"));
}

void BodyStates::mark_changed(std::span<const std::uint32_t> bodies)
{
    in_chunks(bodies, [&](std::span<const std::uint32_t> some) {
        std::uint32_t* out = changes_.data() + change_count_;
        std::uint8_t* states = states_.data(); // local copy: bytes may alias everything
        std::uint8_t any = 0;
        const bool run = is_run(some);
        for (std::size_t k = 0; run && k < some.size(); ++k) any |= states[some[0] + k];
        if (run && !(any & changed)) {
            states += some[0];
            for (std::size_t k = 0; k < some.size(); ++k) states[k] |= changed;
            out = std::copy(some.begin(), some.end(), out);
        } else {
            for (std::uint32_t body : some) {
                *out = body;
                out += !(states[body] & changed);
                states[body] |= changed;
            }
        }
        change_count_ = static_cast<std::size_t>(out - changes_.data());
        ONCOLLIDE_ASSERT(change_count_ <= states_.size());
        return true;
    });
}

inline void BodyStates::set_dynamic(std::uint32_t body, bool now)
{
    if (is(body, dynamic) == now) return;
    states_[body] ^= dynamic;
    now ? ++dynamic_count_ : --dynamic_count_;
    ++dynamic_version_;
}

void BodyStates::add(std::span<const std::uint32_t> bodies, bool is_static)
{
    require(bodies, false);
    if (bodies.empty()) return;
    if (const std::size_t largest = std::ranges::max(bodies); largest >= states_.size()) {
        changes_.resize(largest + 2);
        states_.resize(largest + 1);
    }
    mark_changed(bodies);
    for (std::uint32_t body : bodies) {
        set(body, present);
        set_dynamic(body, !is_static);
    }
    ONCOLLIDE_ASSERT(dynamic_count_ <= size_ + bodies.size() && size_ + bodies.size() <= states_.size());
    size_ += bodies.size();
    came_or_went_ = true;
}

void BodyStates::remove(std::span<const std::uint32_t> bodies)
{
    require(bodies, true);
    mark_changed(bodies);
    for (std::uint32_t body : bodies) {
        set_dynamic(body, false);
        clear(body, present);
    }
    ONCOLLIDE_ASSERT(bodies.size() <= size_ && dynamic_count_ <= size_ - bodies.size());
    size_ -= bodies.size();
    came_or_went_ |= !bodies.empty();
}

void BodyStates::move(std::span<const std::uint32_t> bodies)
{
    require(bodies, true);
    mark_changed(bodies);
}

void BodyStates::set_dynamic(std::span<const std::uint32_t> bodies, bool now)
{
    require(bodies, true);
    mark_changed(bodies);
    for (std::uint32_t body : bodies) set_dynamic(body, now);
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
    if (change_count_ * 4 > states_.size())
        for (std::uint8_t& state : states_) state &= static_cast<std::uint8_t>(~changed);
    else
        for (std::uint32_t body : changes()) clear(body, changed);
    change_count_ = 0;
    came_or_went_ = false;
}

void BodyStates::list(std::vector<std::uint32_t>& bodies) const
{
    bodies.clear();
    for (std::uint32_t body = 0; body < rows(); ++body)
        if (states_[body] & present) bodies.push_back(body);
}

std::string BodyStates::validate() const
{
    std::size_t here = 0, moving = 0, marked = 0;
    for (const std::uint8_t state : states_) {
        here += bool(state & present), moving += bool(state & dynamic), marked += bool(state & changed);
        if (state & dynamic && !(state & present)) return "a body that is absent is dynamic";
    }
    if (here != size_ || moving != dynamic_count_) return "a wrong number of bodies or of dynamic bodies";
    if (changes_.size() < change_count_ || marked != change_count_) return "a wrong number of changed bodies";
    for (std::uint32_t body : changes())
        if (!is(body, changed)) return the_body(body) + ": is listed as changed, but not marked";
    return {};
}

TracksBodies::TracksBodies(const Options& options) : options_(options)
{
    if (!(options.margin >= 0 && options.margin <= 1e15) || options.threads < 1)
        throw Error(ErrorKind::usage, "broad phase: margin must be from 0 to 1e15 m, threads 1 or more");
}

void TracksBodies::check_query(const BodyColumns& columns) const
{
    bodies_.check(columns);
    if (!taken_in_) throw Error(ErrorKind::usage, "broad phase: query() before take_in() of the changes");
}

} // namespace oncollide
