#pragma once
#include <memory>
#include <thread>
#include <unordered_map>

#include <oncollide/pipeline/world.hpp>

#include "bindings.hpp"
#include "release.hpp"

namespace oncollide::python {

/// A model in Python.
struct ModelHandle {
    using InModule = void;
    ModelId id;
};

/// The World, its users, and the thread that it is tied to.
struct HeldWorld : std::enable_shared_from_this<HeldWorld> {
    using InModule = void;
    Interrupts interrupts;
    World world;
    Users users;
    std::unordered_map<ModelId, GeometryHandle> geometries; ///< as Python gave them
    const bool tied;                                        ///< a GPU ties it to its thread
    const std::thread::id home = std::this_thread::get_id();

    explicit HeldWorld(const Settings& settings);
    /// Throws Error{usage} on another thread, if it is tied, and in a signal handler in the middle of a call.
    Users& users_for(const char* call);

private:
    Settings with_stop(Settings settings);
};

/// A part of a World in Python: it keeps the World alive.
struct View {
    using InModule = void;
    std::shared_ptr<HeldWorld> held;

    explicit View(HeldWorld& world) : held(world.shared_from_this()) {}
};
struct ModelsView : View {
    using View::View;
};
struct BodiesView : View {
    using View::View;
};
struct PairsView : View {
    using View::View;
};
struct SpaceView : View {
    using View::View;
};

/// Exclusive use of a World for one call.
struct Inside : Users::Alone {
    Inside(HeldWorld& held, const char* call) : Alone(held.users_for(call), call) {}
};
/// Shared use with other const calls.
struct Looking : Users::Beside {
    Looking(HeldWorld& held, const char* call) : Beside(held.users_for(call), call) {}
};

/// Returns query(world); other Python threads run meanwhile. Ctrl-C ends a batch soon.
template <class Query>
auto computed(HeldWorld& held, const char* call, bool batch, Query query)
{
    auto found = [&] {
        const Looking looking(held, call);
        const Released released(batch ? &held.interrupts : nullptr);
        for (;;) {
            const unsigned cuts = held.interrupts.cuts();
            auto results = query(std::as_const(held.world));
            if (released.interruptible() || (cuts % 2 == 0 && held.interrupts.cuts() == cuts)) return results;
        }
    }();
    if (batch) held.interrupts.rethrow();
    return found;
}

ModelId model_of(py::handle value, const Place& place);
std::uint32_t bits(py::handle value, const Place& place);
CollisionFilter filter_of(py::handle layer, py::handle mask, py::handle group, const char* call);
MotionPath motion_path(py::handle value, const Place& place); ///< "linear" or "screw"
SweepOptions sweep_options(py::handle time, py::handle gap, py::handle steps, py::handle stop, const char* call);
DistanceOptions distance_options(py::handle tolerance, py::handle cutoff, const char* call);
ManifoldOptions manifold_options(py::handle margin, py::handle normal_spread, py::handle points_per_region,
                                 py::handle regions_per_pair, py::handle points_per_pair, py::handle points_in_all,
                                 py::handle measures, const char* call);
Aabb box_of(py::handle low, py::handle high, const char* call);
py::list stage_list(std::span<const StageStats> stages);

/// A property or a method that is a const call.
template <class Look>
auto look(const char* call, Look work)
{
    return [call, work](HeldWorld& held) {
        const Looking looking(held, call);
        return work(held.world);
    };
}

/// Arguments that several calls have, with their defaults.
struct SharedArguments {
    py::arg_v layer{"layer", 1}, mask{"mask", 0xffffffffu}, group{"group", 0};
    py::arg_v path{"path", "linear"}, time_tolerance{"time_tolerance", SweepOptions().time_tolerance},
        gap_tolerance{"gap_tolerance", SweepOptions().gap_tolerance},
        most_steps{"most_steps", SweepOptions().most_steps}, stop{"stop", "contact"};
    py::arg_v margin{"margin", ManifoldOptions().margin},
        normal_spread{"normal_spread", ManifoldOptions().normal_spread},
        points_per_region{"points_per_region", ManifoldOptions().points_per_region},
        regions_per_pair{"regions_per_pair", ManifoldOptions().regions_per_pair},
        points_per_pair{"points_per_pair", ManifoldOptions().points_per_pair},
        points_in_all{"points_in_all", ManifoldOptions().points_in_all},
        measures{"measures", ManifoldOptions().measures};
};

using WorldClass = py::class_<HeldWorld, std::shared_ptr<HeldWorld>>;
void bind_models(py::module_& module);
void bind_bodies(py::module_& module);
void bind_pairs(py::module_& module);
void bind_space(py::module_& module);
void bind_frames(py::module_& module, WorldClass& world);
void bind_manifolds(py::module_& module, WorldClass& world);

} // namespace oncollide::python
