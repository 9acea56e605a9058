// Many states of one scene, eight side by side, on several threads; where contacts of the eight do
// not act alike, each for itself in the law of contact.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "impact/coefficients.hpp"
#include "scene/scene.hpp"
#include "spatial/loads.hpp"

namespace impulsekit {

// The numbers of all rows, or of one that all share; null where the scene's own hold.
struct Column {
    const double* data = nullptr;
    std::size_t width = 0;
    bool varies = false;

    const double* row(int i) const { return data ? data + (varies ? width * i : 0) : nullptr; }
};

struct BatchInput {
    int size = 0;
    Column q, v, impulses, restitution, friction, masses, points;
    Column function_rows, function_contacts;
    const std::int8_t* codes = nullptr;  // (size) what is known of a row before it is solved
    // Slopes are those of the sum of results with these weights, one set of each row; or, where
    // there are none, of these results by their numbers. See Derivation for both.
    Column weights;
    std::vector<int> results, parameters;  // the parameters that are written
};

// (size, …) each; null where it is not asked for.
struct BatchOutput {
    double *v_after = nullptr, *dv = nullptr, *generalized_impulse = nullptr;
    double *energy_change = nullptr, *contact_impulses = nullptr, *constraint_impulses = nullptr;
    double *normal_components = nullptr, *reactions = nullptr, *bodies = nullptr;
    double* gaps = nullptr;  // by contact, of the lowest of its points; NaN where none touches
    std::int8_t* codes = nullptr;
    double* slopes = nullptr;          // (size, results or 1, parameters)
    std::int8_t* existence = nullptr;  // (size) whether there are slopes
};

struct Batch {
    const Scene* scene = nullptr;
    const ContactLaw* law = nullptr;
    bool is_regular = false;  // whether M can be singular at no state
    std::vector<int> joints;  // the body behind each joint
    std::vector<Link> links;
    BatchInput in;
    BatchOutput out;
};

// Solve all rows. `look`: called now and then on the calling thread with the rows done; what it
// throws, or a function of a coefficient, ends the batch.
void solve_rows(const Batch& batch, int threads, const std::function<void(int)>& on_progress);

}  // namespace impulsekit
