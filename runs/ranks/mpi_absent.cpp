// Replaces the MPI sources if ONCOLLIDE_MPI=OFF.
#include <oncollide/runs/ranks/partitioner.hpp>

namespace oncollide {

namespace {

[[noreturn]] void refuse_without_mpi()
{
    throw Error(ErrorKind::usage, "oncollide was built without MPI; build it with -DONCOLLIDE_MPI=ON (Open MPI and "
                                  "Zoltan: libopenmpi-dev, libtrilinos-zoltan-dev)");
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

std::unique_ptr<Partitioner> make_zoltan_partitioner(const Ranks&)
{
    refuse_without_mpi();
}

} // namespace oncollide
