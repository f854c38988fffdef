#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/pipeline/ranks/bytes.hpp>

namespace oncollide {

/// The processes of one job ("ranks"), as one of them sees them. All ranks make the same calls in the same order; a
/// call waits until all that it needs have made it. Where a rank dies, the others do not come back from a call.
class Ranks {
public:
    virtual ~Ranks() = default;
    virtual int rank() const = 0; ///< from 0
    virtual int size() const = 0;

    /// out[r] goes to rank r; in[r] is what rank r sent here. Both of size().
    virtual void exchange(std::span<const Bytes> out, std::vector<Bytes>& in) = 0;
    /// all[r] is what rank r gave.
    virtual void gather(const Bytes& mine, std::vector<Bytes>& all) = 0;
    /// Each number becomes the sum over all ranks, or the largest of them.
    virtual void sum(std::span<std::uint64_t> numbers) = 0;
    virtual void most(std::span<double> numbers) = 0;
    /// The sum of `number` over the ranks before this one.
    virtual std::uint64_t before(std::uint64_t number) = 0;
    /// One number, which waits until the receiver asks for it.
    virtual void send(int to, std::uint64_t number) = 0;
    virtual std::uint64_t receive(int from) = 0;
    /// Ends all processes at once, with this exit code. Ranks that are threads go on: the caller throws.
    virtual void abort(int code) = 0;
};

/// An Error that all ranks throw at once.
struct ErrorOfAll : Error {
    using Error::Error;
};

/// Does `work` on this rank. If it throws on any, all throw ErrorOfAll, with the kind and the text of the first of
/// these, and its rank.
void together(Ranks& ranks, const std::function<void()>& work);

/// Calls `work` as each of `size` ranks, on threads of this process: to test what ranks do, and for one rank alone.
/// Throws what the first of them threw.
void run_ranks_on_threads(int size, const std::function<void(Ranks&)>& work);

/// Was this process started by mpirun, srun or the like, as one of several or alone? Costs a look at the environment.
bool started_by_mpi();
/// How many processes were started together, and which of them this one is, by the environment alone.
int mpi_size_of_environment();
int mpi_rank_of_environment();
/// Is ONCOLLIDE_MPI on?
bool mpi_is_built();
/// The ranks of MPI; once in the life of a process, which ends MPI when it is destroyed. With ONCOLLIDE_MPI=OFF it
/// throws Error{usage} that names the option.
std::unique_ptr<Ranks> make_mpi_ranks();

} // namespace oncollide
