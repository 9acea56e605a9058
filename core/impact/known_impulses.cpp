#include "impact/known_impulses.hpp"

namespace impulsekit {

void solve_known(KnownImpulses<double>& known, const double* q, const double* numbers, double* dv) {
    known.place(q);
    known.tree.factor();
    known.respond(numbers, dv);
}

}  // namespace impulsekit
