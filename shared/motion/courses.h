// Courses: the announced changes of things that rules of a game move, by the number of the thing.
#pragma once

#include "shared/core/assert.h"
#include "shared/core/ids.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::motion {

/// The things of a world that rules move, as one side knows them. Two sides with the same courses
/// have a thing alike at each tick. Courses are announced ahead of time, so a side that has heard
/// of them knows the thing before it turns. A course has `Tick from`.
template <class Course>
class Courses {
  public:
    /// Of one thing. The oldest are forgotten first, but for the one that holds.
    static constexpr std::size_t kMostCourses = 32;

    Courses() = default;

    explicit Courses(std::size_t things) : courses_(things) {}

    [[nodiscard]] std::size_t size() const { return courses_.size(); }

    /// The course holds from course.from on and replaces those announced for then and later. Adding
    /// one twice changes nothing. False, and no change, where there is no room for it.
    bool announce(std::uint32_t thing, const Course& course, Tick now) {
        if (!has_room(thing, course.from, now)) {
            return false;
        }
        std::vector<Course>& courses = courses_[thing];
        courses.resize(begun(courses, course.from - 1));
        if (courses.size() == kMostCourses) {
            courses.erase(courses.begin());
        }
        courses.push_back(course);
        return true;
    }

    /// Whether fewer than kMostCourses hold at `now` or later and before the tick.
    [[nodiscard]] bool has_room(std::uint32_t thing, Tick from, Tick now) const {
        ZONED_ASSERT(thing < courses_.size(), "a course is of a thing that there is");
        const std::vector<Course>& courses = courses_[thing];
        return begun(courses, from - 1) < kMostCourses || courses[1].from <= now;
    }

    /// The course that holds at a tick; null before the first one that is kept.
    [[nodiscard]] const Course* at(std::uint32_t thing, Tick tick) const {
        const std::size_t count = begun(courses_[thing], tick);
        return count == 0 ? nullptr : &courses_[thing][count - 1];
    }

    /// The course that holds at a tick, and all that are announced for later, ascending.
    [[nodiscard]] std::span<const Course> from(std::uint32_t thing, Tick tick) const {
        const std::size_t count = begun(courses_[thing], tick);
        return std::span(courses_[thing]).subspan(count == 0 ? 0 : count - 1);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        const std::size_t things = courses_.size();
        archive(courses_);
        if constexpr (Archive::kReads) {
            if (courses_.size() != things) {
                archive.fail("courses of more or fewer things than there are");
            }
        }
    }

  private:
    /// The number of courses that begin at the tick or before.
    static std::size_t begun(std::span<const Course> courses, Tick tick) {
        const auto later =
            std::upper_bound(courses.begin(), courses.end(), tick, [](Tick t, const Course& c) {
                return t < c.from;
            });
        return static_cast<std::size_t>(later - courses.begin());
    }

    std::vector<std::vector<Course>> courses_;  // by thing, ascending
};

}  // namespace zoned::motion
