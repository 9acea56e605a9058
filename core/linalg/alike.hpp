// One program for states side by side: questions that it puts to all of them at once.
#pragma once

#include "linalg/numbers.hpp"

namespace impulsekit {

// One state decides for itself.
template <typename S>
class Alike {
  public:
    bool operator()(bool answer) const { return answer; }
    bool expect(bool answer, bool) const { return answer; }
    bool keep(bool answer) const { return answer; }
};

// Of eight the most decide: those that differ are left for another time. What is not as it is
// expected fails, and goes its own way.
template <>
class Alike<Pack> {
  public:
    explicit Alike(const PackBits& states) : in_(states) {}

    // The answer of the most.
    bool operator()(const PackBits& answer) {
        const PackBits yes = in_ & (answer != 0), no = in_ & (answer == 0);
        const bool is_yes = count(yes) > count(no);
        differing_ |= is_yes ? no : yes;
        in_ = is_yes ? yes : no;
        return is_yes;
    }
    bool expect(const PackBits& answer, bool expected) {
        in_ &= expected ? answer != 0 : answer == 0;
        return expected;
    }
    // False where none is left.
    bool keep(const PackBits& answer) { return any(in_ &= answer != 0); }

    const PackBits& in() const { return in_; }
    const PackBits& differing() const { return differing_; }

    static int count(const PackBits& states) {
        std::int64_t sum = 0;
        for (int k = 0; k < kLanes; ++k) sum -= states[k];
        return static_cast<int>(sum);
    }

  private:
    PackBits in_, differing_{};
};

}  // namespace impulsekit
