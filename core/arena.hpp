// Scratch memory for one call: taken piece by piece, given back all at once, never freed between
// calls, so that inner loops do not allocate.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

namespace impulsekit {

class Arena {
  public:
    // Zeroed room for `count` numbers, valid until the mark before it is released.
    double* take(int count) {
        std::size_t size = static_cast<std::size_t>(std::max(count, 1));
        while (chunk_ < chunks_.size() && used_ + size > chunks_[chunk_].size) next();
        if (chunk_ == chunks_.size()) {
            std::size_t room = std::max(size, kChunk);
            chunks_.push_back({std::make_unique<double[]>(room), room});
        }
        double* start = chunks_[chunk_].data.get() + used_;
        used_ += size;
        std::fill(start, start + size, 0.0);
        return start;
    }

    int* take_int(int count) {
        static_assert(sizeof(int) <= sizeof(double), "integers are kept in rooms of doubles");
        return reinterpret_cast<int*>(take(count));
    }

    // Gives back, at its end, all that was taken in its life.
    class Scope {
      public:
        explicit Scope(Arena& arena) : arena_(arena), chunk_(arena.chunk_), used_(arena.used_) {}
        ~Scope() {
            arena_.chunk_ = chunk_;
            arena_.used_ = used_;
        }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

      private:
        Arena& arena_;
        std::size_t chunk_, used_;
    };

  private:
    struct Chunk {
        std::unique_ptr<double[]> data;
        std::size_t size;
    };
    static constexpr std::size_t kChunk = 1 << 14;

    void next() {
        ++chunk_;
        used_ = 0;
    }

    std::vector<Chunk> chunks_;
    std::size_t chunk_ = 0, used_ = 0;
};

// The scratch memory of this thread.
inline Arena& scratch() {
    thread_local Arena arena;
    return arena;
}

}  // namespace impulsekit
