#pragma once
#include <array>
#include <optional>

#include "held_world.hpp"

namespace oncollide::python {

/// A Model, or many: Models, or an array of their numbers, whose memory is used if it is contiguous and of uint64.
class ModelArguments {
public:
    ModelArguments(py::handle value, const Place& place);
    ModelArguments(const ModelArguments&) = delete;

    bool one() const { return one_; }
    std::span<const ModelId> all() const { return models_; }
    ModelId operator[](std::size_t i) const { return models_[one_ ? 0 : i]; }

private:
    py::object kept_;
    std::vector<ModelId> made_;
    ModelId single_;
    std::span<const ModelId> models_;
    bool one_ = true;
};

/// One side of a pair, or of many: a body's id, ids (N,), a model at a pose, or models at poses.
class Side {
public:
    Side(py::handle value, const Place& place, Lengths& lengths, bool may_move = false);

    /// The side, if it is one and not many. Valid as long as this object.
    PairSide only() const { return models_ ? PairSide(placed_) : PairSide((*bodies_)[0]); }
    const std::optional<Ids>& bodies() const { return bodies_; }
    ModelColumns columns(const World& world); ///< bodies as models at their poses
    /// Entry i as a motion, from its pose to its end; without an end it rests.
    MovingModel moving(const World& world, std::size_t i, MotionPath path) const;

private:
    std::optional<Ids> bodies_;
    std::optional<ModelArguments> models_;
    std::optional<Poses> poses_, ends_;
    PlacedModel placed_;
    std::vector<ModelId> made_models_; ///< models of bodies
    std::vector<double> made_poses_;
};

/// The two sides of a pair, or of many pairs.
class Sides {
public:
    Sides(const char* call, py::handle a, py::handle b, bool may_move = false)
        : lengths_(call), a_(a, {call, "a"}, lengths_, may_move), b_(b, {call, "b"}, lengths_, may_move)
    {
    }
    bool one() const { return lengths_.one(); }
    std::size_t size() const { return lengths_.size(); }
    const Side& a() const { return a_; }
    const Side& b() const { return b_; }
    PairSpan pairs(const World& world); ///< valid as long as this object

private:
    Lengths lengths_;
    Side a_, b_;
    std::vector<PairOfBodies> bodies_;
};

} // namespace oncollide::python
