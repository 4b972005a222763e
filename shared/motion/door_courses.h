// DoorCourses: when the rules of a game open and shut the doors that they move.
#pragma once

#include "shared/motion/courses.h"

#include <optional>

namespace zoned::motion {

/// From a tick on a door is open, or shut.
struct DoorCourse {
    Tick from = 0;
    bool open = false;

    friend bool operator==(const DoorCourse&, const DoorCourse&) = default;
};

/// By the number of the door in the world.
class DoorCourses : public Courses<DoorCourse> {
  public:
    using Courses<DoorCourse>::Courses;

    /// None before the first course that is kept: the door is as its timetable says.
    [[nodiscard]] std::optional<bool> open_at(std::uint32_t door, Tick tick) const {
        const DoorCourse* course = at(door, tick);
        return course == nullptr ? std::nullopt : std::optional(course->open);
    }
};

}  // namespace zoned::motion
