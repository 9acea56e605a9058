// Many contact problems of one size, given by their matrices.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/problem.hpp"

namespace impulsekit {

// Rows of numbers, one for each problem or one that all share.
struct SharedRows {
    const double* data = nullptr;
    std::size_t width = 0;  // 0 where all share one

    const double* row(std::size_t i) const { return data + i * width; }
};

struct ContactProblems {
    std::size_t count = 0;
    int contacts = 0;
    const double *W = nullptr, *before = nullptr, *free = nullptr;  // (count, r, r), (count, r)
    SharedRows restitution, friction, tangential;                   // (contacts)
};

struct ContactProblemSolutions {
    std::vector<double> impulse, after, residual;  // (count, r), (count, r), (count)
    std::vector<std::int8_t> status;               // (count)
};

// Throws std::invalid_argument with what the law refuses.
ContactProblemSolutions solve_problems(const ContactProblems& given, const Law& law, int threads);

}  // namespace impulsekit
