// Long work looks now and then for what is to end it, such as Ctrl-C.
#pragma once

#include <cstddef>

namespace impulsekit {

// Set what looks, where Python is known; what it throws ends the work.
void set_signal_check(void (*check)());

// Count work that was done on this thread, and look if there was enough of it.
void poll(std::size_t multiplications);

// The same in products of sizes, which as integers could overflow.
inline void poll(int a, int b, int c = 1) {
    poll(static_cast<std::size_t>(a) * static_cast<std::size_t>(b) * static_cast<std::size_t>(c));
}

}  // namespace impulsekit
