#pragma once
#include <memory>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>

#include "temporary_folder.hpp"

namespace oncollide::test {

/// One mesh of hills in two Worlds: in memory, and in a cooked file that is read on demand.
class CookedHills {
public:
    CookedHills()
    {
        const Mesh hills = make_hills_mesh(200, 1, 20, 3, 0, 0, 200);
        cook_mesh(hills, folder_.path() / "hills.cooked");
        whole.bodies().add({.model = whole.models().add(hills)});
        parts.bodies().add(
            {.model = parts.models().add(std::make_shared<const CookedMesh>(folder_.path() / "hills.cooked"))});
    }
    /// A random segment in a fifth of the hills.
    static Segment segment(std::uint64_t k)
    {
        return {Eigen::Vector3d(40 * u01(7, k, 0), 200 * u01(7, k, 1), 20 * u01(7, k, 2)),
                Eigen::Vector3d(40 * u01(7, k, 3), 200 * u01(7, k, 4), 20 * u01(7, k, 5))};
    }

private:
    TemporaryFolder folder_; // outlives the Worlds

public:
    World whole, parts;
};

} // namespace oncollide::test
