// Shared environment: clocks and courses of a world (time of day, weather) that every side computes
// for itself from constants that are sent once.
#pragma once

#include "shared/core/ids.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::clock {

/// A stretch of a clock. From tick `from` on, its value is value + rate_per_s * (t - from) *
/// tick_s.
struct ClockCourse {
    Tick from = 0;
    double value = 0.0;
    double rate_per_s = 0.0;

    friend bool operator==(const ClockCourse&, const ClockCourse&) = default;
};

/// A clock that runs piecewise at constant rates. Two sides with the same courses have the same
/// value for the same tick, to the last bit. They differ only in the tick that each takes for the
/// present. So the drift is the error of the tick clock times the rate.
class SharedClock {
  public:
    /// Number of courses kept; the oldest are forgotten first.
    static constexpr std::size_t kMostCourses = 16;

    /// `tick_s` > 0. With `period` > 0 the value wraps into [0, period).
    SharedClock(double tick_s, double period) : tick_s_(tick_s), period_(period) {}

    /// The course holds from course.from on and replaces courses announced for then and later.
    /// Adding a course twice changes nothing.
    void announce(const ClockCourse& course);

    /// Value at a tick with its fraction; none before the first course kept.
    [[nodiscard]] std::optional<double> at(double tick) const;

    /// The course that holds at a tick, and all courses announced for later, ascending.
    [[nodiscard]] std::span<const ClockCourse> from(Tick tick) const;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(courses_);
    }

  private:
    [[nodiscard]] double wrapped(double value) const;

    double tick_s_;
    double period_;
    std::vector<ClockCourse> courses_;  // ascending
};

/// One of the states that a shared variable passes through.
struct VariablePhase {
    std::string name;
    double value = 0.0;   ///< value that the variable goes to
    double weight = 1.0;  ///< > 0: relative probability of being next
    double min_s = 60.0;  ///< duration, uniform in [min, max]
    double max_s = 600.0;
};

struct SharedVariableDef {
    std::string name;
    std::uint64_t seed = 0;
    double blend_s = 0.0;  ///< time from the old value to a new phase's value, linearly
    std::vector<VariablePhase> phases;
};

/// The present state of a variable: phase number `number` (0, 1, 2, ...) began at `since`, with the
/// value `before`.
struct VariableCursor {
    std::uint64_t number = 0;
    Tick since = 0;
    std::uint32_t phase = 0;
    double before = 0.0;

    friend bool operator==(const VariableCursor&, const VariableCursor&) = default;
};

/// A value that follows a course drawn from a seed: phases that never follow themselves (where
/// there is more than one), each of a random length. Length and successor of phase number n are a
/// function of seed and n alone, so one cursor determines the whole future.
class SharedVariable {
  public:
    /// Most phases over which a cursor is carried on at a time; more means a mistake or an attack.
    static constexpr int kMostPhases = 100000;

    SharedVariable(SharedVariableDef def, double tick_s) : def_(std::move(def)), tick_s_(tick_s) {}

    [[nodiscard]] const SharedVariableDef& def() const { return def_; }

    /// Phase number 0, at tick 0.
    [[nodiscard]] VariableCursor begin() const;
    /// The cursor of a tick at or after `from.since`; none for an earlier tick or one too far
    /// ahead.
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
    Tick sync_ticks = 1800;  ///< time between two reports of the present state to everybody

    [[nodiscard]] bool empty() const { return clocks.empty() && variables.empty(); }
};

/// All clocks and variables of a world, on one side.
class SharedEnvironment {
  public:
    /// Values are available for this long into the past.
    static constexpr Tick kRemembered = 600;

    SharedEnvironment() = default;
    SharedEnvironment(const EnvironmentDefs& defs, double tick_s);

    /// The authority begins with the first courses and phases. A client knows nothing before the
    /// first message.
    void begin(const EnvironmentDefs& defs);

    void announce(std::size_t clock, const ClockCourse& course);
    /// Takes over the state of a variable from a side that knows it. Returns the difference between
    /// the new and the old value at the cursor's tick (0: no old value).
    double place(std::size_t variable, const VariableCursor& cursor);
    /// Advances cursors, so that values of ticks near `now` are found quickly.
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

    /// Value of a clock or a variable; none where neither exists, or it is not known.
    [[nodiscard]] std::optional<double> at(std::string_view name, Tick tick) const;
    /// Index of the clock of that name; none without one.
    [[nodiscard]] std::optional<std::size_t> find_clock(std::string_view name) const;

    /// The courses and cursors; the definitions are there already.
    template <class Archive>
    void serialize(Archive& archive) {
        for (SharedClock& clock : clocks_) {
            archive(clock);
        }
        for (std::optional<VariableCursor>& cursor : cursors_) {
            archive(cursor);
        }
        if constexpr (Archive::kReads) {
            for (std::size_t v = 0; v < cursors_.size(); ++v) {
                if (cursors_[v] && cursors_[v]->phase >= variables_[v].def().phases.size()) {
                    archive.fail("a shared variable is in a phase that there is not");
                }
            }
        }
    }

  private:
    std::vector<std::string> clock_names_;
    std::vector<SharedClock> clocks_;
    std::vector<SharedVariable> variables_;
    std::vector<std::optional<VariableCursor>> cursors_;  // of kRemembered ticks ago, or newer
};

}  // namespace zoned::clock
