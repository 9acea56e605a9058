// What an impact does to the joints and links of a robot.
#pragma once

#include <vector>

#include "scene/contact_frame.hpp"
#include "spatial/loads.hpp"

namespace impulsekit {

// An impact by its velocity jump and impulses.
struct ImpactImpulses {
    const double *q, *dv;   // (nq), (nv)
    const double* numbers;  // of the known impulses
    const double* lambda;   // (rows)
    const double* P;        // (3 (points + turning))
};

// The loads of an impact of a scene at the points of `rows`.
Loads impact_loads(const Scene& scene, const Links& links, const StateRows& rows,
                   const ImpactImpulses& given);

// (3 points) the moments of all points, of (3 turning) those that resist turning.
std::vector<double> moments_by_point(std::size_t points, const std::vector<int>& turning_of,
                                     const double* moments);

}  // namespace impulsekit
