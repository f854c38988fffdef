#pragma once
#include <thread>

#include <oncollide/pipeline/world.hpp>

#include "bindings.hpp"
#include "release.hpp"

namespace oncollide::python {

/// A model in Python; it records its World, so that another World refuses it.
struct ModelHandle {
    using InModule = void;
    std::uint64_t world;
    ModelId id;
    friend bool operator==(const ModelHandle&, const ModelHandle&) = default;
};

/// The World, its users, and the thread that it is tied to.
struct HeldWorld {
    using InModule = void;
    Interrupts interrupts;
    World world;
    const std::uint64_t number; ///< unique among the Worlds of this process
    Users users;
    const bool tied; ///< a GPU ties it to its thread
    const std::thread::id home = std::this_thread::get_id();

    explicit HeldWorld(const Settings& settings);
    void at_home(const char* call) const; ///< throws Error{usage} on another thread

private:
    Settings with_stop(Settings settings);
};

/// Exclusive use of a World for one call.
struct Inside : Users::Alone {
    Inside(HeldWorld& held, const char* call) : Alone(held.users, call) { held.at_home(call); }
};
/// Shared use with other const calls.
struct Looking : Users::Beside {
    Looking(HeldWorld& held, const char* call) : Beside(held.users, call) { held.at_home(call); }
};

/// The model's id in this World. ValueError if the model belongs to another World.
ModelId model_of(const HeldWorld& held, py::handle value, const Place& place);
std::uint32_t bits(py::handle value, const Place& place);
CollisionFilter filter_of(py::handle layer, py::handle mask, py::handle group, const char* call);
MotionPath motion_path(py::handle value, const Place& place); ///< "linear" or "screw"
Aabb box_of(py::handle low, py::handle high, const char* call);

/// A property or a method that is a const call.
template <class Look>
auto look(const char* call, Look work)
{
    return [call, work](HeldWorld& held) {
        const Looking looking(held, call);
        return work(held.world);
    };
}

using WorldClass = py::class_<HeldWorld>;
// Each adds its part to World.
void bind_bodies(WorldClass& world);
void bind_frames(py::module_& module, WorldClass& world);
void bind_world_queries(WorldClass& world);
void bind_world_pairs(WorldClass& world);
void bind_world_sweeps(WorldClass& world);
void bind_maps(WorldClass& world);

} // namespace oncollide::python
