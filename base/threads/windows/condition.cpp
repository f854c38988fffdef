#include <oncollide/base/threads/windows/condition.hpp>

#include <windows.h>

namespace oncollide {

void Condition::notify_one()
{
    ++turn_;
    if (sleepers_ != 0) WakeByAddressSingle(&turn_);
}

void Condition::notify_all()
{
    ++turn_;
    if (sleepers_ != 0) WakeByAddressAll(&turn_);
}

void Condition::sleep(std::uint32_t turn)
{
    static_assert(sizeof turn_ == sizeof turn);
    ++sleepers_;
    WaitOnAddress(&turn_, &turn, sizeof turn, INFINITE);
    --sleepers_;
}

} // namespace oncollide
