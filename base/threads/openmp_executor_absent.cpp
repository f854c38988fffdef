// Replaces openmp_executor.cpp in builds without OpenMP.
#include <oncollide/base/error.hpp>
#include <oncollide/base/executor.hpp>

namespace oncollide {

Executor& openmp_executor()
{
    throw Error(ErrorKind::usage, "this is a build without OpenMP (ONCOLLIDE_OPENMP=OFF); use thread_pool()");
}

} // namespace oncollide
