#include <cstdlib>

#include <oncollide/runs/ranks/ranks.hpp>

namespace oncollide {

namespace {

/// The first of these variables that is set, as a number; -1 if none is set.
int variable(std::initializer_list<const char*> names)
{
    for (const char* name : names)
        if (const char* text = std::getenv(name); text && *text) return std::atoi(text);
    return -1;
}

} // namespace

// For Open MPI, and for MPICH and its derivatives. Plain srun sets none of these; srun --mpi=pmix sets PMIX_RANK.
int mpi_size_of_environment()
{
    return std::max(1, variable({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}));
}

int mpi_rank_of_environment()
{
    return std::max(0, variable({"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}));
}

bool started_by_mpi()
{
    return variable({"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}) >= 0;
}

} // namespace oncollide
