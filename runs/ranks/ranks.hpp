#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/runs/ranks/bytes.hpp>

namespace oncollide {

/// The processes of one job ("ranks"), as seen by one of them. Collective calls must be made by all ranks in the same
/// order; a call waits for the ranks that it needs. If a rank dies, calls on the other ranks do not return.
class Ranks {
public:
    virtual ~Ranks() = default;
    virtual int rank() const = 0; ///< counted from 0
    virtual int size() const = 0;

    /// Sends out[r] to rank r and receives in[r] from rank r. Both have size() elements.
    virtual void exchange(std::span<const Bytes> out, std::vector<Bytes>& in) = 0;
    /// Sets all[r] to the `mine` of rank r.
    virtual void gather(const Bytes& mine, std::vector<Bytes>& all) = 0;
    /// Replaces each number by its sum or its maximum over all ranks.
    virtual void sum(std::span<std::uint64_t> numbers) = 0;
    virtual void most(std::span<double> numbers) = 0;
    /// The sum of `number` over all lower ranks.
    virtual std::uint64_t before(std::uint64_t number) = 0;
    /// Sends one number. Does not wait for the receiver.
    virtual void send(int to, std::uint64_t number) = 0;
    virtual std::uint64_t receive(int from) = 0;
    /// Ends all processes immediately with this exit code. Ranks that are threads continue, and the caller throws.
    virtual void abort(int code) = 0;
};

/// An Error that all ranks throw together.
struct ErrorOfAll : Error {
    using Error::Error;
};

/// Calls `work` on this rank. If it throws on any rank, all ranks throw ErrorOfAll with the kind, text and number of
/// the first such rank.
void together(Ranks& ranks, const std::function<void()>& work);

/// Calls `work` as each of `size` ranks, on threads of this process: for tests, and for a single rank. Rethrows the
/// first exception.
void run_ranks_on_threads(int size, const std::function<void(Ranks&)>& work);

/// True if mpirun, srun or the like started this process, alone or with others. Reads only the environment.
bool started_by_mpi();
/// The number of processes started together and the index of this one, according to the environment.
int mpi_size_of_environment();
int mpi_rank_of_environment();
/// True if ONCOLLIDE_MPI is on.
bool mpi_is_built();
/// The MPI ranks. Call once per process; destroying the result ends MPI. With ONCOLLIDE_MPI=OFF, throws Error{usage}
/// naming the option.
std::unique_ptr<Ranks> make_mpi_ranks();

} // namespace oncollide
