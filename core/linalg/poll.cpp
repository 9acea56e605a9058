#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

// Multiplications between two looks: some 0.05 s.
constexpr std::size_t kWorkBetweenChecks = std::size_t{1} << 26;

void (*check_signals)() = nullptr;

}  // namespace

void set_signal_check(void (*check)()) { check_signals = check; }

void poll(std::size_t multiplications) {
    thread_local std::size_t done = 0;
    done += multiplications;
    if (done < kWorkBetweenChecks) return;
    done = 0;
    if (check_signals) check_signals();
}

}  // namespace impulsekit
