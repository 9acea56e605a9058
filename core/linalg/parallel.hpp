// Independent work on several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace impulsekit {

// Call `work()` once on each thread for a function of the number of an item, and that function for
// every number below `count`. The first exception ends all.
template <typename Work>
void run_parallel(std::size_t count, int threads, const Work& work) {
    std::atomic<std::size_t> next{0};
    std::mutex lock;
    std::exception_ptr error;
    const auto run = [&] {
        try {
            auto item = work();
            for (std::size_t i; (i = next++) < count;) item(i);
        } catch (...) {
            const std::lock_guard<std::mutex> guard(lock);
            if (!error) error = std::current_exception();
            next = count;
        }
    };
    std::vector<std::thread> others;
    const std::size_t most = std::min(count, static_cast<std::size_t>(std::max(threads, 1)));
    for (std::size_t k = 1; k < most; ++k) others.emplace_back(run);
    run();
    for (std::thread& other : others) other.join();
    if (error) std::rethrow_exception(error);
}

}  // namespace impulsekit
