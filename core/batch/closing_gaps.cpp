#include "batch/closing_gaps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace impulsekit {
namespace {

constexpr double kAbsent = std::numeric_limits<double>::infinity();

double square_of_distance(const double* a, const double* b) {
    double total = 0.0;
    for (int k = 0; k < 3; ++k) total += (a[k] - b[k]) * (a[k] - b[k]);
    return total;
}

// The first t > 0 with g + u t + a t²/2 = 0 of what closes; infinite where it does not come to it.
double first_root(double g, double u, double a) {
    const double square = u * u - 2.0 * a * g;
    if (square < 0.0) return kAbsent;
    const double below = std::sqrt(square) - u;
    return below > 0.0 ? 2.0 * g / below : kAbsent;
}

}  // namespace

int contacts_of(const ContactListing& listing) {
    int count = 0;
    for (const ListedContact& own : listing) count += own.number >= 0;
    return count;
}

ClosingGaps::ClosingGaps(const ContactListing& listing, std::vector<std::int64_t> known, int limits,
                         const std::vector<std::int64_t>* handled, double threshold) {
    std::vector<std::int64_t> now;
    for (const ListedContact& own : listing)
        if (own.number >= 0) now.push_back(own.key);
    const bool has_limits = static_cast<int>(listing.size() - now.size()) > limits;
    std::sort(now.begin(), now.end());
    std::sort(known.begin(), known.end());
    const auto count = [](const std::vector<std::int64_t>& keys, std::int64_t key) {
        const auto range = std::equal_range(keys.begin(), keys.end(), key);
        return range.second - range.first;
    };
    for (std::size_t i = 0; i < listing.size(); ++i) {
        const ListedContact& own = listing[i];
        bool is_new = has_limits;
        if (own.number >= 0)
            is_new = count(now, own.key) > count(known, own.key) &&
                     (!handled || std::binary_search(handled->begin(), handled->end(), own.key));
        if (!is_new || !(own.speed < -threshold)) continue;
        Gap gap{own.key, {}, static_cast<int>(i), 0, {}, {}, {0.0, own.gap, own.speed}};
        std::copy(own.position, own.position + 3, gap.position);
        gaps_.push_back(gap);
    }
}

double ClosingGaps::fastest() const {
    double most = 0.0;
    for (const Gap& gap : gaps_) most = std::max(most, std::abs(gap.now.speed));
    return most;
}

double ClosingGaps::least() const {
    double least = kAbsent;
    for (const Gap& gap : gaps_) least = std::min(least, gap.now.gap);
    return least;
}

void ClosingGaps::follow(const ContactListing& listing, double t) {
    for (Gap& gap : gaps_) {
        const ListedContact* nearest = nullptr;
        double least = kAbsent;
        for (const ListedContact& own : listing) {
            if (own.key != gap.key) continue;
            const double apart = square_of_distance(own.position, gap.position);
            if (!nearest || apart < least) nearest = &own, least = apart;
        }
        gap.before = gap.now;
        gap.now = {t, nearest ? nearest->gap : kAbsent, nearest ? nearest->speed : gap.now.speed};
        if (gap.looks++ == 0) gap.start = gap.now;
        if (!nearest) continue;
        gap.entry = static_cast<int>(nearest - listing.data());
        std::copy(nearest->position, nearest->position + 3, gap.position);
    }
}

std::vector<int> ClosingGaps::hits(double reach, double threshold) const {
    std::vector<int> found;
    for (const Gap& gap : gaps_)
        if (std::isfinite(gap.now.gap) && gap.now.gap <= reach && gap.now.speed < -threshold)
            found.push_back(gap.entry);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

void ClosingGaps::drop(double reach) {
    const auto is_closed = [&](const Gap& gap) { return gap.now.gap <= reach; };
    gaps_.erase(std::remove_if(gaps_.begin(), gaps_.end(), is_closed), gaps_.end());
}

double ClosingGaps::closing_time(double low, double high, double half_closed) const {
    double first = kAbsent;
    for (const Gap& gap : gaps_) first = std::min(first, closing_time_of(gap, half_closed));
    return low < first && first < high ? first : 0.5 * (low + high);
}

double ClosingGaps::closing_time_of(const Gap& gap, double half_closed) {
    const Look &start = gap.start, &before = gap.before, &now = gap.now;
    if (!std::isfinite(now.gap)) return kAbsent;
    const double left = now.gap - half_closed;
    if (gap.looks < 2 || !std::isfinite(start.gap)) return now.t + first_root(left, now.speed, 0.0);
    // Parabolas begin with the rate of the start, or go through the last look but one.
    const double mean = (now.gap - start.gap) / now.t;
    if (gap.looks == 2 || !std::isfinite(before.gap) || before.t == now.t || before.t == start.t) {
        const double bend = 2.0 * (mean - start.speed) / now.t;
        return first_root(start.gap - half_closed, start.speed, bend);
    }
    const double late = (now.gap - before.gap) / (now.t - before.t);
    const double early = (before.gap - start.gap) / before.t;
    const double bend = 2.0 * (late - early) / now.t;
    const double rate = late + 0.5 * bend * (now.t - before.t);
    const double square = rate * rate - 2.0 * bend * left;
    if (!(rate < 0.0) || square < 0.0) return kAbsent;
    return now.t + 2.0 * left / (std::sqrt(square) - rate);
}

}  // namespace impulsekit
