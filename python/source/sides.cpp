#include "sides.hpp"

namespace oncollide::python {

ModelArguments::ModelArguments(py::handle value, const Place& place)
{
    if (py::isinstance<ModelHandle>(value)) {
        single_ = model_of(value, place);
        models_ = {&single_, 1};
        return;
    }
    if (!is_many(value)) refuse_type(place, "a Model, as models.add() returns it, or many", value);
    one_ = false;
    if (py::isinstance<py::array>(value) && py::reinterpret_borrow<py::array>(value).dtype().kind() == 'u') {
        const py::array array = whole_numbers(value, place);
        if (array.ndim() != 1) refuse_value(place, "expected shape (N,) of models, got " + shape_of(array));
        static_assert(sizeof(ModelId) == 8);
        models_ = {static_cast<const ModelId*>(array.data()), static_cast<std::size_t>(array.shape(0))};
        kept_ = array;
        return;
    }
    if (!PySequence_Check(value.ptr())) refuse_type(place, "a sequence of Models", value);
    for (const py::handle each : py::reinterpret_borrow<py::sequence>(value)) made_.push_back(model_of(each, place));
    models_ = made_;
}

Side::Side(py::handle value, const Place& place, Lengths& lengths, bool may_move)
{
    if (!py::isinstance<py::tuple>(value)) {
        bodies_.emplace(value, place);
        lengths.add(place.argument, bodies_->one(), bodies_->size());
        return;
    }
    const auto parts = py::reinterpret_borrow<py::tuple>(value);
    if (parts.size() != 2 && !(may_move && parts.size() == 3))
        refuse_value(place, may_move ? "expected the id of a body, or a tuple (model, pose) or (model, start, end)"
                                     : "expected the id of a body, or a tuple (model, pose)");
    models_.emplace(parts[0], place);
    poses_.emplace(parts[1], place);
    lengths.add(place.argument, models_->one(), models_->all().size());
    lengths.add(place.argument, poses_->one(), poses_->size());
    if (parts.size() == 3) {
        ends_.emplace(parts[2], place);
        lengths.add(place.argument, ends_->one(), ends_->size());
    } else if (models_->one() && poses_->one()) {
        placed_ = {(*models_)[0], (*poses_)[0]};
    }
}

ModelColumns Side::columns(const World& world)
{
    if (models_) return {models_->all(), poses_->rows()};
    made_models_.clear(), made_poses_.clear();
    for (const BodyId id : *bodies_) {
        made_models_.push_back(world.bodies().model(id));
        const Eigen::Matrix4d columns = world.bodies().pose(id).matrix().transpose();
        made_poses_.insert(made_poses_.end(), columns.data(), columns.data() + 16);
    }
    return {made_models_, made_poses_};
}

MovingModel Side::moving(const World& world, std::size_t i, MotionPath path) const
{
    if (bodies_) return {world.bodies().model((*bodies_)[i]), world.bodies().pose((*bodies_)[i])};
    if (!ends_) return {(*models_)[i], (*poses_)[i]};
    return {(*models_)[i], RigidMotion((*poses_)[i], (*ends_)[i], path)};
}

PairSpan Sides::pairs(const World& world)
{
    if (!a_.bodies() || !b_.bodies()) return PairOfColumns{a_.columns(world), b_.columns(world)};
    bodies_.clear();
    for (std::size_t i = 0; i < size(); ++i) bodies_.push_back({(*a_.bodies())[i], (*b_.bodies())[i]});
    return bodies_;
}

} // namespace oncollide::python
