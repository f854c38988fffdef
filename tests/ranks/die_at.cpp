// Preloaded into a process of a job, kills it at a chosen time: DIE_AT=PHASE:COUNT:RANK, in the COUNT-th call of that
// phase. The remains are realistic: an interrupted write is partly written.
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <dlfcn.h>
#include <fcntl.h>
#include <mpi.h>
#include <signal.h>
#include <sys/time.h>
#include <unistd.h>

namespace {

struct Plan {
    std::string phase;
    int count = 0;
    Plan()
    {
        const char* text = std::getenv("DIE_AT");
        const char* own = std::getenv("OMPI_COMM_WORLD_RANK");
        char name[32];
        int rank = 0;
        if (text && own && std::sscanf(text, "%31[a-z-]:%d:%d", name, &count, &rank) == 3 && rank == std::atoi(own))
            phase = name;
    }
};

bool due(const char* phase)
{
    static const Plan plan;
    static std::atomic<int> calls{0};
    return plan.phase == phase && ++calls == plan.count;
}

void die(int = 0)
{
    if (const char* mark = std::getenv("DIE_MARK")) ::close(::open(mark, O_CREAT | O_WRONLY, 0600)); // time of death
    ::kill(::getpid(), SIGKILL);
}

template <class Function>
Function real(Function, const char* name)
{
    return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}
#define REAL(name) static const auto of_library = real(&::name, #name)

/// Whether it is the file of a checkpoint, not of rows.
bool of_checkpoint(int file)
{
    char path[512] = {};
    const std::string link = "/proc/self/fd/" + std::to_string(file);
    return ::readlink(link.c_str(), path, sizeof path - 1) > 0 && std::strstr(path, "check.");
}

} // namespace

extern "C" {

FILE* fopen64(const char* path, const char* mode)
{
    REAL(fopen64);
    if (std::strstr(path, ".json") && due("load")) die();
    return of_library(path, mode);
}

/// The largest of six numbers are the bounds of all bodies: a partition begins.
int MPI_Allreduce(const void* a, void* b, int count, MPI_Datatype type, MPI_Op d, MPI_Comm e)
{
    REAL(MPI_Allreduce);
    if (count == 6 && type == MPI_DOUBLE && due("partition")) die();
    return of_library(a, b, count, type, d, e);
}

int MPI_Alltoall(const void* a, int b, MPI_Datatype c, void* d, int e, MPI_Datatype f, MPI_Comm g)
{
    REAL(MPI_Alltoall);
    if (due("exchange")) die();
    return of_library(a, b, c, d, e, f, g);
}

/// Bodies have arrived: the World steps next.
int MPI_Waitall(int a, MPI_Request b[], MPI_Status c[])
{
    REAL(MPI_Waitall);
    const int result = of_library(a, b, c);
    if (due("narrow")) {
        ::signal(SIGALRM, die);
        const itimerval soon{{0, 0}, {0, 300}};
        ::setitimer(ITIMER_REAL, &soon, nullptr);
    }
    return result;
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t at)
{
    REAL(pwrite);
    if (due("full")) return errno = ENOSPC, -1;
    if (due(of_checkpoint(file) ? "checkpoint" : "write")) of_library(file, bytes, size / 2, at), die();
    return of_library(file, bytes, size, at);
}

int fsync(int file)
{
    REAL(fsync);
    if (due("sync")) die();
    return of_library(file);
}

int rename(const char* from, const char* to)
{
    REAL(rename);
    if (due("rename")) die();
    const int result = of_library(from, to);
    if (due("renamed")) die();
    return result;
}
}
