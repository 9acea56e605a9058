// Explicit Runge-Kutta methods as tables (Hairer, Norsett & Wanner, Solving Ordinary Differential
// Equations I, 1993).
#pragma once

namespace impulsekit {

// Rows of the stages of a step, of its end, and of further stages of dense output, each its time
// and then the weights of the rates before it: y + h Σ weight rate stands at t + h time.
struct Tableau {
    int stages, all;           // of a step; rows
    int order;                 // of the error's estimate
    const double* velocities;  // (all, all) rows of velocities, and of places
    const double* places;
    const double* errors;  // (estimates, stages + 1) of the error, the second one of lower order
    int estimates;
    const double* bends;  // (count, all) of coefficients of dense output beyond its cubic
    int count;
};

// Dormand and Prince of order 8 with errors of orders 5 and 3 and dense output of order 7 (section
// II.10), and of order 5 (table II.5.2); Kutta's 3/8-rule of order 4, whose error the rate at its
// end tells (eq. (II.4.9)): two fifths and a quarter of the work, for steps that are cut short by
// what lies ahead. The method of order 4 of fixed steps; and that of order 1 whose places move by
// the velocities of the end.
extern const Tableau kDop853, kDopri5, kKutta, kRk4, kSemiImplicit;

}  // namespace impulsekit
