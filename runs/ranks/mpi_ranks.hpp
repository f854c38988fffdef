#pragma once
#include <mpi.h>

namespace oncollide {

/// The communicator of all ranks; valid while the result of make_mpi_ranks() exists.
MPI_Comm mpi_communicator();

} // namespace oncollide
