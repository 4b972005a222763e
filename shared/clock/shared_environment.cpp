#include "shared/clock/shared_environment.h"

#include "shared/core/assert.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::clock {

// ---------------------------------------------------------------- clocks

void SharedClock::announce(const ClockCourse& course) {
    const auto later = std::lower_bound(
        courses_.begin(), courses_.end(), course.from, [](const ClockCourse& c, Tick from) {
            return c.from < from;
        });
    courses_.erase(later, courses_.end());
    if (courses_.size() >= kMostCourses) {
        courses_.erase(courses_.begin());
    }
    courses_.push_back(course);
}

std::optional<double> SharedClock::at(double tick) const {
    for (auto it = courses_.rbegin(); it != courses_.rend(); ++it) {
        const double since = tick - static_cast<double>(it->from);
        if (since >= 0.0) {
            return wrapped(it->value + it->rate_per_s * (since * tick_s_));
        }
    }
    return std::nullopt;
}

std::span<const ClockCourse> SharedClock::from(Tick tick) const {
    std::size_t first = 0;
    while (first + 1 < courses_.size() && courses_[first + 1].from <= tick) {
        ++first;
    }
    return std::span(courses_).subspan(std::min(first, courses_.size()));
}

double SharedClock::wrapped(double value) const {
    if (!(period_ > 0.0)) {
        return value;
    }
    const double rest = std::fmod(value, period_);
    const double up = rest < 0.0 ? rest + period_ : rest;
    return up < period_ ? up : 0.0;  // a rest of almost nothing below zero rounds to the period
}

// ---------------------------------------------------------------- variables

double SharedVariable::unit(std::uint64_t number, std::uint64_t use) const {
    const std::uint64_t bits = core::mix(core::mix(def_.seed ^ core::mix(2 * number + use)));
    return static_cast<double>(bits >> 11) * 0x1.0p-53;
}

VariableCursor SharedVariable::begin() const {
    VariableCursor first;
    double all = 0.0;
    for (const VariablePhase& phase : def_.phases) {
        all += phase.weight;
    }
    double left = unit(0, 0) * all;
    while (first.phase + 1 < def_.phases.size() && left >= def_.phases[first.phase].weight) {
        left -= def_.phases[first.phase++].weight;
    }
    first.before = def_.phases[first.phase].value;
    return first;
}

Tick SharedVariable::length(const VariableCursor& cursor) const {
    const VariablePhase& phase = def_.phases[cursor.phase];
    const double seconds = phase.min_s + (phase.max_s - phase.min_s) * unit(cursor.number, 1);
    return std::max<Tick>(1, static_cast<Tick>(std::floor(seconds / tick_s_ + 0.5)));
}

VariableCursor SharedVariable::next(const VariableCursor& cursor) const {
    VariableCursor out{cursor.number + 1, cursor.since + length(cursor), cursor.phase, 0.0};
    out.before = value(cursor, out.since);
    double others = 0.0;
    for (std::size_t i = 0; i < def_.phases.size(); ++i) {
        others += i == cursor.phase ? 0.0 : def_.phases[i].weight;
    }
    double left = unit(out.number, 0) * others;
    for (std::uint32_t i = 0; i < def_.phases.size(); ++i) {
        if (i == cursor.phase) {
            continue;
        }
        out.phase = i;
        left -= def_.phases[i].weight;
        if (left < 0.0) {
            break;
        }
    }
    return out;
}

std::optional<VariableCursor> SharedVariable::carry_on(VariableCursor from, Tick tick) const {
    if (tick < from.since) {
        return std::nullopt;
    }
    for (int i = 0; i < kMostPhases; ++i) {
        if (tick - from.since < length(from)) {
            return from;
        }
        from = next(from);
    }
    return std::nullopt;
}

double SharedVariable::value(const VariableCursor& cursor, Tick tick) const {
    const double goal = def_.phases[cursor.phase].value;
    const double passed_s = static_cast<double>(tick - cursor.since) * tick_s_;
    if (!(passed_s < def_.blend_s)) {
        return goal;
    }
    return cursor.before + (goal - cursor.before) * (passed_s / def_.blend_s);
}

// ---------------------------------------------------------------- all of a world

SharedEnvironment::SharedEnvironment(const EnvironmentDefs& defs, double tick_s) {
    for (const SharedClockDef& clock : defs.clocks) {
        clock_names_.push_back(clock.name);
        clocks_.emplace_back(tick_s, clock.period);
    }
    for (const SharedVariableDef& variable : defs.variables) {
        ZONED_ASSERT(!variable.phases.empty(), "a shared variable has phases");
        variables_.emplace_back(variable, tick_s);
    }
    cursors_.resize(variables_.size());
}

void SharedEnvironment::begin(const EnvironmentDefs& defs) {
    for (std::size_t i = 0; i < clocks_.size(); ++i) {
        clocks_[i].announce(defs.clocks[i].first);
    }
    for (std::size_t i = 0; i < variables_.size(); ++i) {
        cursors_[i] = variables_[i].begin();
    }
}

void SharedEnvironment::announce(std::size_t clock, const ClockCourse& course) {
    clocks_[clock].announce(course);
}

double SharedEnvironment::place(std::size_t variable, const VariableCursor& cursor) {
    const std::optional<VariableCursor> mine = cursor_at(variable, cursor.since);
    if (mine == cursor) {
        return 0.0;
    }
    cursors_[variable] = cursor;
    return mine ? std::abs(variables_[variable].value(*mine, cursor.since) -
                           variables_[variable].value(cursor, cursor.since))
                : 0.0;
}

void SharedEnvironment::advance(Tick now) {
    for (std::size_t i = 0; i < cursors_.size(); ++i) {
        if (cursors_[i] && now - kRemembered > cursors_[i]->since) {
            cursors_[i] = variables_[i].carry_on(*cursors_[i], now - kRemembered);
        }
    }
}

std::optional<VariableCursor> SharedEnvironment::cursor_at(std::size_t index, Tick tick) const {
    return cursors_[index] ? variables_[index].carry_on(*cursors_[index], tick) : std::nullopt;
}

std::optional<double> SharedEnvironment::value_at(std::size_t index, Tick tick) const {
    const std::optional<VariableCursor> cursor = cursor_at(index, tick);
    return cursor ? std::optional(variables_[index].value(*cursor, tick)) : std::nullopt;
}

std::optional<double> SharedEnvironment::at(std::string_view name, Tick tick) const {
    if (const std::optional<std::size_t> clock = find_clock(name)) {
        return clock_at(*clock, tick);
    }
    for (std::size_t i = 0; i < variables_.size(); ++i) {
        if (variables_[i].def().name == name) {
            return value_at(i, tick);
        }
    }
    return std::nullopt;
}

std::optional<std::size_t> SharedEnvironment::find_clock(std::string_view name) const {
    const auto it = std::ranges::find(clock_names_, name);
    return it == clock_names_.end()
               ? std::nullopt
               : std::optional(static_cast<std::size_t>(it - clock_names_.begin()));
}

}  // namespace zoned::clock
