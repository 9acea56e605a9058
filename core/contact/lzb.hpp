// Contacts whose impulses grow with their stored energies (Liu, Zhao & Brogliato 2008).
#pragma once

#include "contact/problem.hpp"

namespace impulsekit {

// Each contact has an indentation δ and a normal force F = k δ^n; dP = F dt. While it is compressed
// dδ/dt = −u_n, while it is restored −u_n/e², so that it regains e² of the work of its
// compressions; only ratios of stiffnesses count. A contact of infinite stiffness, or one with
// e = 0 whose compression has ended, is held: u_n = 0 with the force that the equations of motion
// ask for, until that would pull.
//
// Friction opposes the slip of each instant. Under slip="compliant", with n = 1, contacts have
// tangential springs as well, whose deflection is ζ: with χ = κ ζ and d = χ/|χ|
//     sticking  F_t = −k χ,      χ' = κ u_t,                            until |χ| = µ δ,
//     slipping  F_t = −µ F d,    χ' = κ (u_t − (u_t·d) d) + µ δ' d,     until s = 0
// with the speed of slip s = u_t·d − (µ/κ) δ': all of u_t across d turns the spring, and along d it
// grows and falls as the normal force does, which keeps |χ| = µ δ. A damped spring gives back the
// share 1 − D of its work, at every speed, as the normal one gives e²: where |χ| falls it falls
// 1/(1 − D) times as fast, and δ' < 0 in s counts 1 − D times. What is held has no such spring:
// its friction is Coulomb's, as it is of all contacts for κ = ∞. The energy of both springs of all
// contacts falls by what slip and restitution take, and by nothing else.
ContactSolution solve_lzb(const ContactProblem& problem, const Law& law);

}  // namespace impulsekit
