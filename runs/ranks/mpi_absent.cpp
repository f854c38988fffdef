// Replaces the MPI sources if ONCOLLIDE_MPI=OFF.
#include <oncollide/runs/ranks/ranks.hpp>

namespace oncollide {

namespace {

[[noreturn]] void refuse_without_mpi()
{
    throw Error(ErrorKind::usage, "oncollide was built without MPI; build it with -DONCOLLIDE_MPI=ON (Open "
                                  "MPI: libopenmpi-dev)");
}

} // namespace

bool mpi_is_built()
{
    return false;
}

std::unique_ptr<Ranks> make_mpi_ranks()
{
    refuse_without_mpi();
}

} // namespace oncollide
