// Shared environment: clocks and courses of a world (time of day, weather) that every side computes
// for itself from constants that are told once.
#pragma once

#include "shared/core/ids.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::clock {

/// A stretch of a clock: from tick `from` on it shows value + rate_per_s * (t - from) * tick_s.
struct ClockCourse {
    Tick from = 0;
    double value = 0.0;
    double rate_per_s = 0.0;

    friend bool operator==(const ClockCourse&, const ClockCourse&) = default;
};

/// A clock that runs piecewise at constant rates. Both sides that were told the same courses show
/// the same value for the same tick to the last bit: what differs between them is only which tick
/// each takes for the present, so that the drift is the error of the tick clock times the rate.
class SharedClock {
  public:
    /// As many courses are remembered; those of long ago are forgotten first.
    static constexpr std::size_t kMostCourses = 16;

    /// `tick_s` > 0. With `period` > 0 the value wraps into [0, period).
    SharedClock(double tick_s, double period) : tick_s_(tick_s), period_(period) {}

    /// Holds from course.from on, in place of what was announced for then and later. Told of again
    /// it changes nothing.
    void announce(const ClockCourse& course);

    /// At a tick, with its fraction; none before the first course that is remembered.
    [[nodiscard]] std::optional<double> at(double tick) const;

    /// The one that holds at a tick, and all that are announced for later, ascending.
    [[nodiscard]] std::span<const ClockCourse> from(Tick tick) const;

  private:
    [[nodiscard]] double wrapped(double value) const;

    double tick_s_;
    double period_;
    std::vector<ClockCourse> courses_;  // ascending
};

/// One of the states that a shared variable passes through.
struct VariablePhase {
    std::string name;
    double value = 0.0;   ///< that the variable goes to
    double weight = 1.0;  ///< > 0: of being next
    double min_s = 60.0;  ///< it lasts so long, uniform in [min, max]
    double max_s = 600.0;
};

struct SharedVariableDef {
    std::string name;
    std::uint64_t seed = 0;
    double blend_s = 0.0;  ///< from the value before to that of a new phase, linearly
    std::vector<VariablePhase> phases;
};

/// Where a variable stands: phase number `number` (0, 1, 2, ...) began at `since`, with the value
/// `before`.
struct VariableCursor {
    std::uint64_t number = 0;
    Tick since = 0;
    std::uint32_t phase = 0;
    double before = 0.0;

    friend bool operator==(const VariableCursor&, const VariableCursor&) = default;
};

/// A value that follows a course drawn from a seed: phases that never follow themselves (where
/// there is more than one), each of a random length. Length and successor of phase number n are a
/// function of seed and n alone, so whoever knows one cursor knows the whole future.
class SharedVariable {
  public:
    /// A cursor may be carried on over so many phases at a time: more is a mistake, or an attack.
    static constexpr int kMostPhases = 100000;

    SharedVariable(SharedVariableDef def, double tick_s) : def_(std::move(def)), tick_s_(tick_s) {}

    [[nodiscard]] const SharedVariableDef& def() const { return def_; }

    /// Phase number 0, at tick 0.
    [[nodiscard]] VariableCursor begin() const;
    /// The cursor of a tick at or after `from.since`; none where it is before it or too far ahead.
    [[nodiscard]] std::optional<VariableCursor> carry_on(VariableCursor from, Tick tick) const;
    [[nodiscard]] double value(const VariableCursor& cursor, Tick tick) const;
    /// How long a phase lasts, ticks, >= 1.
    [[nodiscard]] Tick length(const VariableCursor& cursor) const;

  private:
    [[nodiscard]] VariableCursor next(const VariableCursor& cursor) const;
    [[nodiscard]] double unit(std::uint64_t number, std::uint64_t use) const;

    SharedVariableDef def_;
    double tick_s_;
};

struct SharedClockDef {
    std::string name;
    double period = 0.0;  ///< 0: does not wrap
    ClockCourse first;
};

struct EnvironmentDefs {
    std::vector<SharedClockDef> clocks;
    std::vector<SharedVariableDef> variables;
    Tick sync_ticks = 1800;  ///< everybody is told where everything stands so often

    [[nodiscard]] bool empty() const { return clocks.empty() && variables.empty(); }
};

/// All clocks and variables of a world, on one side.
class SharedEnvironment {
  public:
    /// Values of the past can be asked for this long.
    static constexpr Tick kRemembered = 600;

    SharedEnvironment() = default;
    SharedEnvironment(const EnvironmentDefs& defs, double tick_s);

    /// The authority begins with the first courses and phases; a client knows of nothing until it
    /// is told.
    void begin(const EnvironmentDefs& defs);

    void announce(std::size_t clock, const ClockCourse& course);
    /// Where a variable stands, from whoever knows. Returns by how much the value of the cursor's
    /// tick was another before (0: none was known).
    double place(std::size_t variable, const VariableCursor& cursor);
    /// Carries cursors on, so that questions about ticks near `now` are answered quickly.
    void advance(Tick now);

    [[nodiscard]] std::size_t clocks() const { return clocks_.size(); }

    [[nodiscard]] std::size_t variables() const { return variables_.size(); }

    [[nodiscard]] const SharedClock& clock(std::size_t index) const { return clocks_[index]; }

    [[nodiscard]] std::optional<double> clock_at(std::size_t index, Tick tick) const {
        return clocks_[index].at(static_cast<double>(tick));
    }

    [[nodiscard]] std::optional<VariableCursor> cursor_at(std::size_t index, Tick tick) const;
    [[nodiscard]] std::optional<double> value_at(std::size_t index, Tick tick) const;

    [[nodiscard]] const SharedVariable& variable(std::size_t index) const {
        return variables_[index];
    }

    /// Of a clock or a variable; none where there is neither, or it is not known.
    [[nodiscard]] std::optional<double> at(std::string_view name, Tick tick) const;
    /// Index of a clock; none where there is none of that name.
    [[nodiscard]] std::optional<std::size_t> find_clock(std::string_view name) const;

  private:
    std::vector<std::string> clock_names_;
    std::vector<SharedClock> clocks_;
    std::vector<SharedVariable> variables_;
    std::vector<std::optional<VariableCursor>> cursors_;  // of kRemembered ticks ago, or newer
};

}  // namespace zoned::clock
