// Contacts and limits close to touching at a state of another simulator, and when they touch.
#pragma once

#include <cstdint>
#include <vector>

namespace impulsekit {

// A contact, or a limit of a joint or tendon.
struct ListedContact {
    std::int64_t key = 0;            // of its pair
    int pair[2] = {0, 0};            // its geoms; of a limit −1 − its kind, and joint or tendon
    double position[3] = {};         // [m], by which contacts of one pair are told apart
    double frame[9] = {};            // rows: the normal, from the first geom, and two tangents
    double gap = 0.0, speed = 0.0;   // how far from touching, and how fast that grows
    int address = 0, dimension = 1;  // the first of its rows, and how many they are
    int number = -1;                 // in the simulator's list of contacts; −1 for a limit
};

// Contacts come first, then limits.
using ContactListing = std::vector<ListedContact>;

int contacts_of(const ContactListing& listing);

// Gaps that close in the course of a step. In all looks at one flight it starts from one state.
class ClosingGaps {
  public:
    // Take what is listed beyond `known`, keys of contacts as often as they touched, and beyond so
    // many limits, and closes faster than a threshold; a negative one takes all. `handled`: sorted
    // keys that count; null for all.
    ClosingGaps(const ContactListing& listing, std::vector<std::int64_t> known, int limits,
                const std::vector<std::int64_t>* handled, double threshold);

    int count() const { return static_cast<int>(gaps_.size()); }
    double fastest() const;
    double least() const;

    // Look at them at a time of the flight: of each pair the nearest, infinite where there is none.
    void follow(const ContactListing& listing, double t);
    // Their numbers in the last listing: of those within a reach that approach faster.
    std::vector<int> hits(double reach, double threshold) const;
    void drop(double reach);
    // When the first of them is `half_closed` [m, rad] from touching, by what was seen of it: a
    // line, then parabolas through three values. The middle where that leads out of bounds.
    double closing_time(double low, double high, double half_closed) const;

  private:
    struct Look {
        double t = 0.0, gap = 0.0, speed = 0.0;
    };
    struct Gap {
        std::int64_t key;
        double position[3];
        int entry;
        int looks = 0;
        Look start, before, now;  // the first, the last but one, the last
    };
    static double closing_time_of(const Gap& gap, double half_closed);

    std::vector<Gap> gaps_;
};

}  // namespace impulsekit
