#include "server/ai/pathfinding/requests/path_request_queue.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

/// The cost of one look-up step, in units of work.
constexpr std::uint64_t kAskUnits = 100;

float ground_distance(Spot a, Spot b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.z - b.z) * (a.z - b.z));
}

Spot spot_under(const Vec3& v) {
    return {v.x(), v.z()};
}

}  // namespace

PathRequestQueue::PathRequestQueue(const QueueSettings& settings)
    : settings_(settings),
      queue_(settings.longest_wait_ticks - 1) {
    ZONED_ASSERT(settings.work_per_tick > 0 && settings.longest_wait_ticks > 0,
                 "settings of paths");
}

bool PathRequestQueue::knows(PathRequestId ticket) const {
    return ticket.slot < requests_.size() && requests_[ticket.slot].round == ticket.round &&
           requests_[ticket.slot].taken;
}

PathRequestId PathRequestQueue::ask(const PathRequest& ask) {
    if (free_.empty()) {
        free_.push_back(static_cast<std::uint32_t>(requests_.size()));
        requests_.emplace_back();
        free_.reserve(requests_.capacity());
    }
    const std::uint32_t number = free_.back();
    free_.pop_back();
    PathRequestEntry& request = requests_[number];
    const std::uint32_t round = request.round;
    request = PathRequestEntry();
    request.round = round;
    request.asker = ask.asker == PathRequest::kAlone ? number : ask.asker;
    request.from.wanted = Vec3(ask.from.x, ask.from_y, ask.from.z);
    request.to.wanted = Vec3(ask.to.x, ask.to_y, ask.to.z);
    request.taken = true;
    ++counts_.asked;
    spend(kAskUnits);
    const PathOutcome ends =
        contains(ask.from) && contains(ask.to) ? locate(request) : PathOutcome::kOffMap;
    if (ends == PathOutcome::kFound) {
        wait(number);
        if (work_left()) {
            prepare_segments(request);
        }
    } else {
        fail(number, ends);
    }
    return {number, request.round};
}

void PathRequestQueue::wait(std::uint32_t number) {
    PathRequestEntry& request = requests_[number];
    request.waiting = true;
    ++counts_.waiting;
    queue_.push(number, request.asker);
}

void PathRequestQueue::free_blocks(PathRequestEntry& request) {
    pool_.give_back(request.corners);
    hinges_.give_back(request.hinges);
    request.corners = {};
    request.hinges = {};
}

void PathRequestQueue::release(PathRequestId ticket) {
    ZONED_ASSERT(knows(ticket), "a ticket that was released");
    PathRequestEntry& request = requests_[ticket.slot];
    request.taken = false;
    ++request.round;
    free_blocks(request);
    if (request.waiting) {  // stays in its queue until its turn
        --counts_.waiting;
        return;
    }
    free_.push_back(ticket.slot);
}

void PathRequestQueue::serve() {
    const std::uint32_t required = queue_.required();
    std::uint32_t served = 0;
    while (!queue_.empty()) {
        const std::uint32_t number = queue_.front();
        PathRequestEntry& request = requests_[number];
        if (!request.taken) {
            queue_.pop();
            request.waiting = false;
            free_.push_back(number);
            ++served;
            continue;
        }
        const bool late = !work_left();
        if (late && served >= required) {
            break;
        }
        ++served;
        request.waiting = false;
        --counts_.waiting;
        // It has walked on since, and the map may have changed.
        const PathOutcome ends = locate(request);
        if (ends != PathOutcome::kFound) {
            queue_.pop();
            fail(number, ends);
            continue;
        }
        found_.outcome = PathOutcome::kFound;
        found_.best = found_.straight = found_.cheap = false;
        found_.cost = 0.0;
        found_.short_m = 0.0F;
        found_.corners.clear();
        found_.hinges.clear();
        find(request, late, found_);
        counts_.longest_wait_ticks = std::max(counts_.longest_wait_ticks, queue_.waited() + 1);
        queue_.pop();
        done(number);
    }
    queue_.tick();
    std::size_t led = 0;
    for (; led < unled_.size() && work_left(); ++led) {
        const PathRequestEntry& request = requests_[unled_[led]];
        if (request.taken && request.waiting && !request.usable) {
            prepare_segments(request);
        }
    }
    unled_.erase(unled_.begin(), unled_.begin() + static_cast<std::ptrdiff_t>(led));
    counts_.work = spent_;
    spent_ = 0;
    std::swap(reported_, answered_);
    answered_.clear();
}

void PathRequestQueue::done(std::uint32_t number) {
    PathRequestEntry& request = requests_[number];
    free_blocks(request);
    request.outcome = found_.outcome;
    request.best = found_.best;
    request.cost = found_.cost;
    request.short_m = found_.short_m;
    request.last = found_.last;
    request.usable = true;
    request.next = 0;
    if (found_.corners.empty()) {
        found_.corners.push_back(spot_under(request.from.on));
    }
    request.corners = pool_.take(static_cast<std::uint32_t>(found_.corners.size()));
    const std::span<Spot> corners = pool_.of(request.corners);
    std::copy(found_.corners.begin(), found_.corners.end(), corners.begin());
    request.hinges = hinges_.take(static_cast<std::uint32_t>(found_.hinges.size()));
    std::copy(found_.hinges.begin(), found_.hinges.end(), hinges_.of(request.hinges).begin());
    request.rest_m = 0.0F;
    for (std::size_t i = 1; i < corners.size(); ++i) {
        request.rest_m += ground_distance(corners[i - 1], corners[i]);
    }
    request.length_m =
        ground_distance(spot_under(request.from.wanted), corners.front()) + request.rest_m;
    ++counts_.served;
    counts_.straight += found_.straight ? 1U : 0U;
    counts_.by_regions += found_.cheap ? 1U : 0U;
    answered_.push_back(number);
}

void PathRequestQueue::fail(std::uint32_t number, PathOutcome outcome) {
    PathRequestEntry& request = requests_[number];
    free_blocks(request);
    request.outcome = outcome;
    request.usable = false;
    ++counts_.served;
    answered_.push_back(number);
}

PathResult PathRequestQueue::answer(PathRequestId ticket) const {
    ZONED_ASSERT(knows(ticket), "a ticket that was released");
    const PathRequestEntry& request = requests_[ticket.slot];
    if (request.waiting && !request.usable) {
        return {};
    }
    return {false, request.outcome, request.best, request.length_m, pool_.of(request.corners)};
}

Spot PathRequestQueue::heading(PathRequestId ticket, Spot at, float near_m) {
    ZONED_ASSERT(knows(ticket), "a ticket that was released");
    PathRequestEntry& request = requests_[ticket.slot];
    if (request.waiting && !request.usable) {
        return first_segment(request, at);
    }
    request.from.wanted.x() = at.x;
    request.from.wanted.z() = at.z;
    const std::span<const Spot> corners = std::as_const(pool_).of(request.corners);
    if (corners.empty()) {
        return at;
    }
    while (request.next + 1 < corners.size() &&
           ground_distance(at, corners[request.next]) <= near_m) {
        request.rest_m -= ground_distance(corners[request.next], corners[request.next + 1]);
        ++request.next;
    }
    return corners[request.next];
}

PathProvider::RequestEnds PathRequestQueue::ends(PathRequestId ticket) const {
    ZONED_ASSERT(knows(ticket), "a ticket that was released");
    const PathRequestEntry& r = requests_[ticket.slot];
    return {{r.from.wanted.x(), r.from.wanted.z()}, {r.to.wanted.x(), r.to.wanted.z()}};
}

void PathRequestQueue::see(PathRequestId ticket, Spot at, float at_y) {
    requests_[ticket.slot].from.wanted = Vec3(at.x, at_y, at.z);
}

float PathRequestQueue::left_m(const PathRequestEntry& request) const {
    const std::span<const Spot> corners = pool_.of(request.corners);
    return ground_distance(spot_under(request.from.wanted), corners[request.next]) + request.rest_m;
}

bool PathRequestQueue::cut(const PathRequestEntry& request) const {
    const std::span<const Hinge> hinges = hinges_.of(request.hinges);
    return std::any_of(hinges.begin(), hinges.end(), [&](const Hinge& h) {
        return h.corner >= request.next && !passable(h);
    });
}

void PathRequestQueue::review(bool opened) {
    requeued_.clear();
    for (std::uint32_t i = 0; i < requests_.size(); ++i) {
        PathRequestEntry& request = requests_[i];
        if (!request.taken) {
            continue;
        }
        const bool broken = request.usable && cut(request);
        const bool longer = !broken && opened && !request.waiting &&
                            request.outcome != PathOutcome::kOffMap &&
                            ((request.outcome != PathOutcome::kFound && may_come_nearer(request)) ||
                             (request.usable && may_be_shorter(request)));
        if (!broken && !longer) {
            continue;
        }
        ++(broken ? counts_.broken : counts_.reviewed);
        requeued_.push_back(i);
        if (broken) {
            request.usable = false;
        }
        if (request.waiting) {
            continue;
        }
        const PathOutcome ends = locate(request);
        if (ends == PathOutcome::kFound) {
            wait(i);
            if (broken) {
                unled_.push_back(i);
            }
        } else {
            fail(i, ends);
        }
    }
}

std::size_t PathRequestQueue::queue_bytes() const {
    return pool_.bytes() + hinges_.bytes() + requests_.capacity() * sizeof(PathRequestEntry) +
           (free_.capacity() + answered_.capacity() + reported_.capacity() + requeued_.capacity() +
            unled_.capacity()) *
               sizeof(std::uint32_t);
}

}  // namespace zoned::ai::pathfinding
