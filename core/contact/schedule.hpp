// In which orders and shares contacts compress, read from numbers in [0, 1], and such numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace impulsekit {

// SplitMix64 (Steele, Lea & Flood 2014): each seed begins a sequence of its own.
class Random {
  public:
    Random(std::uint64_t seed, std::uint64_t stream) : state_(mixed(seed) + mixed(~stream)) {}

    double next() {
        state_ += 0x9e3779b97f4a7c15u;
        return static_cast<double>(mixed(state_) >> 11) * 0x1p-53;
    }

  private:
    static std::uint64_t mixed(std::uint64_t z) {
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }

    std::uint64_t state_;
};

// Weights of contacts lie between e^-7 and e^7: most of them make an order, the rest shares.
inline constexpr double kSpread = 14.0;
// Fractions of an approach that a piece takes away: 2^-4 to 1, half of them whole.
inline constexpr double kHalvings = 4.0;
// Numbers of an order beside the weights; a share of orders in which contacts act together.
inline constexpr int kMore = 3;
inline constexpr double kShared = 0.4;
// One in so many samples tries all contacts at once.
inline constexpr double kOneIn = 4.0;
// An order holds for at most so many pieces, the last one to the end.
inline constexpr double kMostPieces = 16.0;
// Pieces after which all contacts are tried at once, again and again; fractions are at least a half
// then. After the last ones whole impacts follow, whose infinite series have sums.
inline constexpr int kTogether = 32, kWhole = 96;

// The orders of one phase, read from numbers in [0, 1]: a weight of each contact, the fraction of
// a piece, how many pieces follow it, and whether contacts share them. A last number says from
// which order on, if at all, all contacts are tried at once.
class Schedule {
  public:
    Schedule(const double* numbers, int contacts, int orders)
        : numbers_(numbers),
          n_(contacts),
          orders_(orders),
          weights_(contacts),
          together_(static_cast<int>(kOneIn * orders * numbers[size(contacts, orders) - 1])) {
        begin();
    }

    static int size(int contacts, int orders) { return orders * (contacts + kMore) + 1; }

    double weight(int i) const { return weights_[i]; }
    double fraction() const { return fraction_; }
    bool is_shared() const { return is_shared_; }

    // Count a piece.
    void advance() {
        ++pieces_;
        is_new_ = false;
        if (order_ + 1 < orders_ && --left_ <= 0) {
            ++order_;
            is_new_ = true;
            begin();
        }
        if (pieces_ > kTogether) fraction_ = std::max(fraction_, 0.5);
    }

    bool tries_all() const {
        return pieces_ > 0 ? pieces_ % kTogether == 0 || (order_ == together_ && is_new_)
                           : together_ == 0;
    }
    bool is_long() const { return pieces_ >= kWhole; }

  private:
    void begin() {
        const double* x = numbers_ + order_ * (n_ + kMore);
        for (int i = 0; i < n_; ++i) weights_[i] = std::exp(kSpread * (x[i] - 0.5));
        fraction_ = std::exp2(kHalvings * std::min(2.0 * x[n_] - 1.0, 0.0));
        is_shared_ = x[n_ + 2] < kShared;
        left_ = 1 + static_cast<int>(kMostPieces * x[n_ + 1] * x[n_ + 1] * x[n_ + 1]);
    }

    const double* numbers_;
    const int n_, orders_;
    std::vector<double> weights_;
    double fraction_ = 1.0;
    bool is_shared_ = false;
    const int together_;
    int order_ = 0, left_ = 0, pieces_ = 0;
    bool is_new_ = true;
};

}  // namespace impulsekit
