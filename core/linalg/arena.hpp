// Scratch memory for one call: taken piece by piece, given back all at once, kept between calls up
// to a limit, so that inner loops do not allocate.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <vector>

namespace impulsekit {

class Arena {
  public:
    // Zeroed room for `count` numbers, valid until the mark before it is released.
    double* allocate(std::size_t count) {
        const std::size_t size = (std::max(count, std::size_t{1}) + kLine - 1) / kLine * kLine;
        while (chunk_ < chunks_.size() && used_ + size > chunks_[chunk_].size) next();
        if (chunk_ == chunks_.size()) {
            std::size_t room = std::max(size, kChunk);
            chunks_.push_back({std::make_unique<Line[]>(room / kLine), room});
            owned_ += room;
        }
        double* start = chunks_[chunk_].data.get()->numbers + used_;
        used_ += size;
        std::fill(start, start + size, 0.0);
        return start;
    }

    // A matrix; its size as a product of integers could overflow.
    double* allocate(std::size_t rows, std::size_t columns) { return allocate(rows * columns); }

    // Numbers of another kind, such as eight side by side.
    template <typename T>
    T* allocate_of(std::size_t count) {
        static_assert(alignof(T) <= sizeof(Line), "rooms begin at lines of memory");
        return reinterpret_cast<T*>(
            allocate((count * sizeof(T) + sizeof(double) - 1) / sizeof(double)));
    }

    int* allocate_int(std::size_t count) { return allocate_of<int>(count); }

    // Gives back, at its end, all that was taken in its life.
    class Scope {
      public:
        explicit Scope(Arena& arena) : arena_(arena), chunk_(arena.chunk_), used_(arena.used_) {}
        ~Scope() {
            arena_.chunk_ = chunk_;
            arena_.used_ = used_;
            if (chunk_ == 0 && used_ == 0) arena_.release_excess();
        }
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

      private:
        Arena& arena_;
        std::size_t chunk_, used_;
    };

  private:
    static constexpr std::size_t kLine = 8;
    struct alignas(kLine * sizeof(double)) Line {
        double numbers[kLine];
    };
    struct Chunk {
        std::unique_ptr<Line[]> data;
        std::size_t size;
    };
    // Numbers of a chunk, and how many are kept when nothing is in use: 128 kB and 16 MB.
    static constexpr std::size_t kChunk = std::size_t{1} << 14, kKept = std::size_t{1} << 21;

    void next() {
        ++chunk_;
        used_ = 0;
    }

    void release_excess() {
        for (; owned_ > kKept; chunks_.pop_back()) owned_ -= chunks_.back().size;
    }

    std::vector<Chunk> chunks_;
    std::size_t chunk_ = 0, used_ = 0, owned_ = 0;
};

// The scratch memory of this thread.
inline Arena& scratch() {
    thread_local Arena arena;
    return arena;
}

}  // namespace impulsekit
