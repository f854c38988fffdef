#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// The bodies of a broad phase: which are present, which are dynamic, and which changed since pairs were last found.
class BodyStates {
public:
    enum State : std::uint8_t {
        present = 1,
        dynamic = 2,
        changed = 4,
        held = 8,
        queried = 16,
        escaped = 32
    }; ///< the last three are for the owner's use

    // The changes have the same contracts as in BroadPhase.
    void add(std::span<const std::uint32_t> bodies, bool is_static);
    void remove(std::span<const std::uint32_t> bodies);
    void move(std::span<const std::uint32_t> bodies);
    void set_dynamic(std::span<const std::uint32_t> bodies, bool now);
    /// Throws Error{usage} if a column has fewer rows than there are bodies.
    void check(const BodyColumns& columns) const;

    /// Bodies that changed, including removed ones, each once.
    std::span<const std::uint32_t> changes() const { return std::span(changes_).first(change_count_); }
    bool some_came_or_went() const { return came_or_went_; } ///< true if changes() includes additions or removals
    void forget_changes();

    bool is(std::uint32_t body, State state) const { return body < states_.size() && (states_[body] & state); }
    void set(std::uint32_t body, State state)
    {
        ONCOLLIDE_ASSERT(body < rows());
        states_[body] |= state;
    }
    void clear(std::uint32_t body, State state)
    {
        ONCOLLIDE_ASSERT(body < rows());
        states_[body] &= static_cast<std::uint8_t>(~state);
    }
    const std::uint8_t* data() const { return states_.data(); }                       ///< bits of State by body
    std::uint32_t rows() const { return static_cast<std::uint32_t>(states_.size()); } ///< largest body + 1
    std::size_t size() const { return size_; }                                        ///< bodies present
    std::size_t dynamic_count() const { return dynamic_count_; }
    std::uint64_t dynamic_version() const { return dynamic_version_; } ///< grows when a body becomes static or dynamic
    /// Overwrites `bodies` with the bodies present, ascending.
    void list(std::vector<std::uint32_t>& bodies) const;
    /// Returns the first fault of the whole structure as text; empty: it has none. Assertions and tests call it. Cost:
    /// O(n).
    std::string validate() const;
    std::size_t bytes() const { return states_.capacity() + changes_.capacity() * sizeof(changes_[0]); }

private:
    bool all_present(std::span<const std::uint32_t> bodies) const;
    void require(std::span<const std::uint32_t> bodies, bool there) const;
    void mark_changed(std::span<const std::uint32_t> bodies);
    void set_dynamic(std::uint32_t body, bool now);

    std::vector<std::uint8_t> states_;
    std::vector<std::uint32_t> changes_; ///< room for all bodies and one more
    std::size_t change_count_ = 0;
    std::size_t size_ = 0, dynamic_count_ = 0;
    std::uint64_t dynamic_version_ = 0;
    bool came_or_went_ = false;
};

/// The bookkeeping of bodies that all broad phases share.
class TracksBodies : public BroadPhase {
public:
    void add(std::span<const std::uint32_t> bodies, bool is_static) final
    {
        if (!bodies.empty()) bodies_.add(bodies, is_static), taken_in_ = false;
    }
    void remove(std::span<const std::uint32_t> bodies) final
    {
        if (!bodies.empty()) bodies_.remove(bodies), taken_in_ = false;
    }
    void move(std::span<const std::uint32_t> bodies) final
    {
        if (!bodies.empty()) bodies_.move(bodies), taken_in_ = false;
    }
    void make_static(std::span<const std::uint32_t> bodies) final { set_dynamic(bodies, false); }
    void make_dynamic(std::span<const std::uint32_t> bodies) final { set_dynamic(bodies, true); }
    std::size_t size() const final { return bodies_.size(); }
    bool contains(std::uint32_t body) const final { return bodies_.is(body, BodyStates::present); }

protected:
    /// Throws Error{usage} for options out of range.
    explicit TracksBodies(const Options& options);
    /// Throws the errors of query().
    void check_query(const BodyColumns& columns) const;

    Options options_;
    BodyStates bodies_;
    bool taken_in_ = false; ///< true if no change is pending

private:
    void set_dynamic(std::span<const std::uint32_t> bodies, bool now)
    {
        if (!bodies.empty()) bodies_.set_dynamic(bodies, now), taken_in_ = false;
    }
};

} // namespace oncollide
