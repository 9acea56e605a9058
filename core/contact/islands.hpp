// Contacts, and what rests, that do not act on each other, apart.
#pragma once

#include "contact/rest_law.hpp"

namespace impulsekit {

// (rows) the island of every row of W: rows of one owner, and those that W couples, are on one; −1
// of rows without an owner (−1), which couple nothing. The number of islands.
int find_islands(const double* W, int rows, const int* owner, int* island);

// The part of a problem on one island, and where its rows and points are in the whole; in scratch
// memory.
struct RestIsland {
    RestProblem problem;
    int *rows, *points;

    RestIsland(const RestProblem& whole, const int* island, int number);
};

}  // namespace impulsekit
