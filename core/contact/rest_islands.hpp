// Points and joints at rest that do not act on each other, apart.
#pragma once

#include "contact/rest_law.hpp"

namespace impulsekit {

// (rows) the island of every row: rows of one point, and those that W couples, are on one. Their
// number.
int find_islands(const RestProblem& problem, int* island);

// The part of a problem on one island, and where its rows and points are in the whole; in scratch
// memory.
struct RestIsland {
    RestProblem problem;
    int *rows, *points;

    RestIsland(const RestProblem& whole, const int* island, int number);
};

}  // namespace impulsekit
