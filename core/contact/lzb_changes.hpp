// Changes of contacts while their impulses grow: they close, load, turn, part, stick and slip.
#pragma once

#include "contact/lzb_state.hpp"

namespace impulsekit {

// The least margin of any contact to its next change, at y whose rates were just asked for: below
// zero it is past.
double margin_of_change(LzbState& state, const double* y);

// Decide, at the end of a step, what contacts do from there on; y comes onto what that asks for.
void settle_contacts(LzbState& state, double* y);

// Contacts as they first are: those that approach or touch load, or are held if nothing moves them.
void begin_contacts(LzbState& state, double* y);

// True if no contact has a force or approaches, or the forces move nothing any more: `wedged` where
// one of those would give back work.
bool is_impact_over(const LzbState& state, bool& wedged);

}  // namespace impulsekit
