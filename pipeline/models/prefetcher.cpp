#include <oncollide/pipeline/models/prefetcher.hpp>

#include <algorithm>
#include <system_error>

namespace oncollide {

Prefetcher::Prefetcher(std::function<void(const PrefetchPart&)> prepare) : prepare_(std::move(prepare))
{
    try {
        thread_ = std::thread([this] { run(); });
    } catch (const std::system_error&) {
    }
}

Prefetcher::~Prefetcher()
{
    {
        const std::lock_guard lock(mutex_);
        over_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void Prefetcher::set(std::vector<PrefetchPart> parts)
{
    {
        const std::lock_guard lock(mutex_);
        parts_ = std::move(parts);
        std::ranges::reverse(parts_); // run() takes parts from the end
    }
    changed_.notify_all();
}

void Prefetcher::forget(const Model& model)
{
    const std::lock_guard lock(mutex_);
    std::erase_if(parts_, [&](const PrefetchPart& part) { return part.model == &model; });
}

void Prefetcher::run()
{
    std::unique_lock lock(mutex_);
    while (true) {
        changed_.wait(lock, [&] { return over_ || (!parts_.empty() && paused_ == 0); });
        if (over_) return;
        const PrefetchPart part = parts_.back();
        parts_.pop_back();
        busy_ = true;
        lock.unlock();
        prepare_(part);
        lock.lock();
        busy_ = false;
        changed_.notify_all();
    }
}

Prefetcher::Pause::Pause(Prefetcher* of, bool wait) : of_(of)
{
    if (!of_) return;
    std::unique_lock lock(of_->mutex_);
    if (of_->busy_ && !wait) {
        failed_ = true, of_ = nullptr;
        return;
    }
    ++of_->paused_;
    of_->changed_.wait(lock, [&] { return !of_->busy_; });
}

Prefetcher::Pause::~Pause()
{
    if (!of_) return;
    {
        const std::lock_guard lock(of_->mutex_);
        --of_->paused_;
    }
    of_->changed_.notify_all();
}

} // namespace oncollide
