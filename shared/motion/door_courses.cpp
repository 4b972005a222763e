#include "shared/motion/door_courses.h"

#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::motion {

namespace {

/// The number of courses that begin at the tick or before.
std::size_t begun(std::span<const DoorCourse> courses, Tick tick) {
    const auto later =
        std::upper_bound(courses.begin(), courses.end(), tick, [](Tick t, const DoorCourse& c) {
            return t < c.from;
        });
    return static_cast<std::size_t>(later - courses.begin());
}

}  // namespace

bool DoorCourses::announce(std::uint32_t door, const DoorCourse& course, Tick now) {
    if (!has_room(door, course, now)) {
        return false;
    }
    std::vector<DoorCourse>& courses = courses_[door];
    courses.resize(begun(courses, course.from - 1));
    if (courses.size() == kMostCourses) {
        courses.erase(courses.begin());
    }
    courses.push_back(course);
    return true;
}

bool DoorCourses::has_room(std::uint32_t door, const DoorCourse& course, Tick now) const {
    ZONED_ASSERT(door < courses_.size(), "a course is of a door that there is");
    const std::vector<DoorCourse>& courses = courses_[door];
    return begun(courses, course.from - 1) < kMostCourses || courses[1].from <= now;
}

std::optional<bool> DoorCourses::open_at(std::uint32_t door, Tick tick) const {
    const std::size_t count = begun(courses_[door], tick);
    return count == 0 ? std::nullopt : std::optional(courses_[door][count - 1].open);
}

std::span<const DoorCourse> DoorCourses::from(std::uint32_t door, Tick tick) const {
    const std::size_t count = begun(courses_[door], tick);
    return std::span(courses_[door]).subspan(count == 0 ? 0 : count - 1);
}

}  // namespace zoned::motion
