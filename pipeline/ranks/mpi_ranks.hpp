#pragma once
#include <mpi.h>

namespace oncollide {

/// What all ranks talk over, once make_mpi_ranks() has begun MPI.
MPI_Comm mpi_communicator();

} // namespace oncollide
