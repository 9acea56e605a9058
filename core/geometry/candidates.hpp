// Normals along which two convex shapes may be furthest apart.
#pragma once

#include <vector>

#include "geometry/simplex.hpp"

namespace impulsekit::convex {

struct Guess {
    double separation;
    V normal;
};

// The best of the normals of all faces, and of those on which two edges cross; of faces as good as
// edges the face. Of shapes that are not both polytopes all are kept in `guesses`.
Guess best_candidate(const Pair& pair, bool polytopes, std::vector<Guess>& guesses);

}  // namespace impulsekit::convex
