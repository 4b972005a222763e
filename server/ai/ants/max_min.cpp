// build: hot loops
#include "server/ai/ants/max_min.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <limits>

namespace zoned::ai::pathfinding {

namespace {

constexpr std::uint32_t kAntsWithSearch = 25;
constexpr std::uint32_t kNearWithSearch = 20;
constexpr std::uint32_t kNearAlone = 15;
constexpr float kEvaporationWithSearch = 0.2F;
constexpr float kEvaporationAlone = 0.02F;
/// Chance that an ant makes the best tour again once trails are at their limits (section 3.2 of
/// Stuetzle and Hoos).
constexpr double kChanceOfBest = 0.05;
/// Iterations without a better tour after which trails are laid anew.
constexpr std::uint32_t kPatienceWithSearch = 100;
constexpr std::uint32_t kPatienceAlone = 1000;

/// The n-th root of x in (0, 1), by halving: the same on every machine, as powers of a library are
/// not.
double root_of(double x, std::size_t n) {
    double low = 0.0;
    double high = 1.0;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        double power = 1.0;
        double factor = middle;
        for (std::size_t e = n; e > 0; e /= 2) {
            power *= e % 2 == 1 ? factor : 1.0;
            factor *= factor;
        }
        (power < x ? low : high) = middle;
    }
    return high;
}

MaxMinSettings filled(MaxMinSettings s, std::size_t places) {
    const bool search = s.local != LocalSearch::kNone;
    if (s.ants == 0) {
        s.ants = search ? kAntsWithSearch : static_cast<std::uint32_t>(places / 2);
    }
    if (s.neighbours == 0) {
        s.neighbours = search ? kNearWithSearch : kNearAlone;
    }
    if (s.evaporation <= 0.0F) {
        s.evaporation = search ? kEvaporationWithSearch : kEvaporationAlone;
    }
    return s;
}

}  // namespace

MaxMin::MaxMin(const Distances& distances, const MaxMinSettings& settings)
    : distances_(distances),
      settings_(filled(settings, distances.size())),
      near_(std::min<std::size_t>(settings_.neighbours, distances.size() - 1)),
      nearest_(distances.nearest(near_)),
      tour_(distances.size()),
      rng_(settings.seed, 0xA975) {
    ZONED_ASSERT(settings_.evaporation < 1.0F && settings_.nearness <= 8, "settings in range");
    const std::size_t n = distances.size();
    for (std::size_t i = 0; i < nearest_.size(); ++i) {
        near_place_.push_back(nearest_[i].place);
        const Length d = nearest_[i].length;
        // PointsOfInterest on the same spot are as near as half a unit of length.
        const float per = 1.0F / std::max(static_cast<float>(d), 0.5F);
        float power = 1.0F;
        for (std::uint32_t e = 0; e < settings_.nearness; ++e) {
            power *= per;
        }
        nearness_.push_back(power);
    }
    trail_.resize(nearest_.size());
    weight_.resize(nearest_.size());
    share_.resize(near_);
    open_.resize(n);
    walked_.resize(n);
    iteration_best_.resize(n);
    since_restart_.resize(n);
    best_.resize(n);
    root_ = root_of(kChanceOfBest, n);
    // The first limits come from the nearest-neighbour tour.
    std::fill(weight_.begin(), weight_.end(), 0.0F);
    walk();
    set_limits(distances.length_of(walked_));
    lay_anew();
}

bool MaxMin::run(std::uint64_t most_tours, std::int64_t target) {
    while (tours_ < most_tours && best_length_ > target) {
        iterate();
    }
    return best_length_ <= target;
}

void MaxMin::iterate() {
    iteration_length_ = std::numeric_limits<std::int64_t>::max();
    for (std::uint32_t ant = 0; ant < settings_.ants; ++ant) {
        walk();
        tour_.set(walked_);
        tour_.improve(distances_, nearest_, near_, settings_.local);
        const std::int64_t length = distances_.length_of(tour_.order());
        ++tours_;
        if (length < iteration_length_) {
            iteration_length_ = length;
            std::copy(tour_.order().begin(), tour_.order().end(), iteration_best_.begin());
        }
    }
    ++in_this_start_;
    ++since_better_;
    if (iteration_length_ < since_restart_length_) {
        since_restart_length_ = iteration_length_;
        since_restart_ = iteration_best_;
        since_better_ = 0;
    }
    if (iteration_length_ < best_length_) {
        best_length_ = iteration_length_;
        best_ = iteration_best_;
        set_limits(best_length_);
    }
    const bool search = settings_.local != LocalSearch::kNone;
    if (since_better_ > (search ? kPatienceWithSearch : kPatienceAlone)) {
        ++restarts_;
        lay_anew();
        return;
    }
    if (deposits_best()) {
        deposit(since_restart_, since_restart_length_);
    } else {
        deposit(iteration_best_, iteration_length_);
    }
}

/// The more often the longer the start lasts (section 4.2: "the frequency f_gb"); without local
/// search ants need the guidance less.
bool MaxMin::deposits_best() const {
    const std::uint32_t i = in_this_start_;
    if (settings_.local == LocalSearch::kNone) {
        return i % 25 == 0;
    }
    const std::uint32_t every = i < 25 ? 25 : (i < 75 ? 5 : (i < 125 ? 3 : (i < 250 ? 2 : 1)));
    return i % every == 0;
}

void MaxMin::walk() {
    const auto n = static_cast<std::uint32_t>(distances_.size());
    std::fill(open_.begin(), open_.end(), 1.0F);
    Place at = rng_.below(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        walked_[i] = at;
        open_[at] = 0.0F;
        if (i + 1 < n) {
            at = next_of(at);
        }
    }
}

/// Among near neighbours by chance, as trails and nearness weigh them.
Place MaxMin::next_of(Place from) {
    const float* const weight = weight_.data() + from * near_;
    const Place* const to = near_place_.data() + from * near_;
    float* const share = share_.data();
    const float* const open = open_.data();
    const std::size_t near = near_;
    for (std::size_t k = 0; k < near; ++k) {
        share[k] = weight[k] * open[to[k]];
    }
    float sum = 0.0F;
    for (std::size_t k = 0; k < near; ++k) {
        sum += share[k];
    }
    if (sum <= 0.0F) {
        return nearest_open(from);
    }
    float left = rng_.unit() * sum;
    std::size_t last = 0;
    for (std::size_t k = 0; k < near; ++k) {
        last = share[k] > 0.0F ? k : last;
        left -= share[k];
        if (left < 0.0F && share[k] > 0.0F) {
            break;
        }
    }
    return to[last];
}

Place MaxMin::nearest_open(Place from) const {
    constexpr Length kFar = std::numeric_limits<Length>::max();
    const std::size_t n = distances_.size();
    const Length* const to = distances_.from(from).data();
    const float* const open = open_.data();
    Length least = kFar;
    for (std::size_t p = 0; p < n; ++p) {
        least = std::min(least, open[p] > 0.0F ? to[p] : kFar);
    }
    for (Place p = 0; p < n && least < kFar; ++p) {
        if (open[p] > 0.0F && to[p] == least) {
            return p;
        }
    }
    return from;
}

void MaxMin::lay_anew() {
    std::fill(trail_.begin(), trail_.end(), most_trail_);
    since_restart_length_ = std::numeric_limits<std::int64_t>::max();
    since_better_ = 0;
    in_this_start_ = 0;
    weigh();
}

/// Equations 7 and 11 of Stuetzle and Hoos; with local search the looser limit of their section
/// 4.2.
void MaxMin::set_limits(std::int64_t length) {
    const auto n = static_cast<double>(distances_.size());
    const double most = 1.0 / (static_cast<double>(settings_.evaporation) *
                               static_cast<double>(std::max<std::int64_t>(length, 1)));
    const double chosen_from = 0.5 * static_cast<double>(near_);
    const double least = settings_.local != LocalSearch::kNone
                             ? most / (2.0 * n)
                             : most * (1.0 - root_) / (std::max(chosen_from - 1.0, 1.0) * root_);
    most_trail_ = static_cast<float>(most);
    least_trail_ = static_cast<float>(std::min(least, most));
}

void MaxMin::deposit(std::span<const Place> tour, std::int64_t length) {
    const float stays = 1.0F - settings_.evaporation;
    for (float& t : trail_) {
        t *= stays;
    }
    const float amount = 1.0F / static_cast<float>(std::max<std::int64_t>(length, 1));
    for (std::size_t i = 0; i < tour.size(); ++i) {
        const Place next = tour[i + 1 < tour.size() ? i + 1 : 0];
        deposit_on(tour[i], next, amount);
        deposit_on(next, tour[i], amount);
    }
    weigh();
}

void MaxMin::deposit_on(Place from, Place to, float amount) {
    for (std::size_t k = from * near_; k < (from + 1) * near_; ++k) {
        if (near_place_[k] == to) {
            trail_[k] += amount;
            return;
        }
    }
}

void MaxMin::weigh() {
    for (std::size_t k = 0; k < trail_.size(); ++k) {
        trail_[k] = std::clamp(trail_[k], least_trail_, most_trail_);
        weight_[k] = trail_[k] * nearness_[k];
    }
}

}  // namespace zoned::ai::pathfinding
