// World: contacts and penetrations of pairs.
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/pipeline/world/query_worker.hpp>

namespace oncollide {

/// The trees must be there. Appends.
void WorldImpl::contacts(QueryWorker& worker, const PairTask& task, std::vector<Contact>& found)
{
    models.with_room([&, begin = found.size()] {
        found.resize(begin);
        tests_for(task).contacts(worker.pairs, task, found);
    });
}

std::vector<Contact> Pairs::contacts(PairSide a, PairSide b) const
{
    WorldImpl& p = *world_;
    const PairTask task = p.checked_task(a, b);
    p.need_trees({&task, 1});
    std::vector<Contact> found;
    WorldImpl::Lease worker(p);
    p.contacts(*worker, task, found);
    return found;
}

void Pairs::contacts(PairSpan pairs, Lists<Contact>& found) const
{
    const PairTasks tasks = world_->ready_tasks("contacts", pairs);
    world_->gather(tasks.size(), 16, found,
                   [&](auto& worker, std::size_t i, auto& list) { world_->contacts(worker, tasks[i], list); });
}

/// The trees must be there.
Penetration WorldImpl::penetration(QueryWorker& worker, const PairTask& task)
{
    const auto measure = tests_for(task).penetration;
    if (!measure || reads_a_part(task)) {
        Penetration none;
        none.supported = false;
        return none;
    }
    return models.with_room([&] { return measure(worker.pairs, task); });
}

Penetration Pairs::penetration(PairSide a, PairSide b) const
{
    WorldImpl& p = *world_;
    const PairTask task = p.checked_task(a, b);
    p.need_trees({&task, 1});
    WorldImpl::Lease worker(p);
    return p.penetration(*worker, task);
}

void Pairs::penetration(PairSpan pairs, std::span<Penetration> found) const
{
    const PairTasks tasks = world_->ready_tasks("penetration", pairs);
    same_room("penetration", "pairs", tasks.size(), "results", found.size());
    world_->each(tasks.size(), 4,
                 [&](auto& worker, std::size_t i) { found[i] = world_->penetration(worker, tasks[i]); });
}

} // namespace oncollide
