#include "impact/coefficients.hpp"

#include <algorithm>

#include "linalg/dense.hpp"

namespace impulsekit {

double BySpeed::at(double speed) const {
    if (function) return function(speed);
    if (!table.empty()) return table.at(speed);
    return speed >= capture ? value : 0.0;
}

ContactLaw::ContactLaw(const Law& own, std::vector<ContactCoefficients> coefficients)
    : law(own), contacts(std::move(coefficients)) {
    for (const ContactCoefficients& contact : contacts) {
        has_models = has_models || contact.model.kind != Friction::Kind::number;
        has_adhesion = has_adhesion || contact.adhesion > 0.0;
        has_damping = has_damping || contact.tangential_damping > 0.0;
    }
}

void PointCoefficients::set(const ContactLaw& law, const StateRows& rows, const double* e,
                            const double* mu, const double* v, ContactProblem& c) {
    const std::size_t n = rows.points.size(), turning = rows.turning_of.size();
    numbers_.resize(7 * n + 2 * turning);
    double *restitution = numbers_.data(), *friction = restitution + n, *tangential = friction + n,
           *stiffness = tangential + n, *adhesion = stiffness + n, *rolling = adhesion + n,
           *torsion = rolling + turning, *ratio = torsion + turning, *damping = ratio + n;
    models_.resize(law.has_models && !mu ? n : 0);
    for (std::size_t i = 0; i < n; ++i) {
        const ContactFrame<double>& point = rows.points[i];
        const ContactCoefficients& own = law.contacts[point.entry];
        if (e) {
            restitution[i] = e[point.entry];
        } else if (own.restitution.is_constant()) {
            restitution[i] = own.restitution.value;
        } else {
            const std::size_t normal = 3 * i + 2, nv = rows.J.size() / (3 * (n + turning));
            const double speed = c.before
                                     ? c.before[normal]
                                     : dot(rows.J.data() + normal * nv, v, static_cast<int>(nv));
            restitution[i] = own.restitution.at(std::max(-speed, 0.0));
        }
        friction[i] = mu ? mu[point.entry] : own.friction;
        tangential[i] = own.tangential;
        stiffness[i] = own.stiffness;
        adhesion[i] = own.adhesion;
        ratio[i] = own.stiffness_ratio;
        damping[i] = own.tangential_damping;
        if (models_.empty()) continue;
        models_[i] = own.model;
        models_[i].axis[0] = point.ellipse[0];
        models_[i].axis[1] = point.ellipse[1];
    }
    for (std::size_t i = 0; i < turning; ++i) {
        const auto& own = law.contacts[rows.points[rows.turning_of[i]].entry];
        rolling[i] = own.rolling;
        torsion[i] = own.torsion;
    }
    c.contacts = static_cast<int>(n);
    c.turning = static_cast<int>(turning);
    c.restitution = restitution;
    c.friction = friction;
    c.tangential = tangential;
    const bool is_compliant = law.law.slip == Slip::compliant;
    if (is_compliant || law.law.restitution == Restitution::lzb) c.stiffness = stiffness;
    if (is_compliant) c.stiffness_ratio = ratio;
    if (is_compliant && law.has_damping) c.damping = damping;
    if (law.has_adhesion) c.adhesion = adhesion;
    c.turning_of = rows.turning_of.data();
    c.rolling = rolling;
    c.torsion = torsion;
    if (!models_.empty()) c.models = models_.data();
}

}  // namespace impulsekit
