// DoorCourses: when the rules of a game open and shut the doors that they move.
#pragma once

#include "shared/core/ids.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::motion {

/// From a tick on a door is open, or shut.
struct DoorCourse {
    Tick from = 0;
    bool open = false;

    friend bool operator==(const DoorCourse&, const DoorCourse&) = default;
};

/// The doors of a world that rules move, as one side knows them, by the number of the door in the
/// world. Two sides with the same courses have a door alike at each tick. Courses are announced
/// ahead of time, so a side that has heard of them knows the door before it turns.
class DoorCourses {
  public:
    /// Of one door. The oldest are forgotten first, but for the one that holds.
    static constexpr std::size_t kMostCourses = 32;

    DoorCourses() = default;

    explicit DoorCourses(std::size_t doors) : courses_(doors) {}

    [[nodiscard]] std::size_t doors() const { return courses_.size(); }

    /// The course holds from course.from on and replaces those announced for then and later. Adding
    /// one twice changes nothing. False, and no change, where there is no room for it.
    bool announce(std::uint32_t door, const DoorCourse& course, Tick now);

    /// Whether fewer than kMostCourses hold at `now` or later and before the course.
    [[nodiscard]] bool has_room(std::uint32_t door, const DoorCourse& course, Tick now) const;

    /// None before the first course that is kept: the door is as its timetable says.
    [[nodiscard]] std::optional<bool> open_at(std::uint32_t door, Tick tick) const;

    /// The course that holds at a tick, and all that are announced for later, ascending.
    [[nodiscard]] std::span<const DoorCourse> from(std::uint32_t door, Tick tick) const;

    template <class Archive>
    void serialize(Archive& archive) {
        const std::size_t doors = courses_.size();
        archive(courses_);
        if constexpr (Archive::kReads) {
            if (courses_.size() != doors) {
                archive.fail("courses of more or fewer doors than there are");
            }
        }
    }

  private:
    std::vector<std::vector<DoorCourse>> courses_;  // by door, ascending
};

}  // namespace zoned::motion
