// CrowdAgents: those who walk in a crowd, in columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::ai::steering {

/// Discs on the ground. All columns have the same length; a row is an agent.
struct CrowdAgents {
    std::vector<float> x, z;            ///< m
    std::vector<float> vx, vz;          ///< m/s, as moved in the last step
    std::vector<float> want_x, want_z;  ///< m/s, as they would walk alone
    std::vector<float> radius;          ///< m, > 0
    std::vector<float> most_speed;      ///< m/s, >= 0
    /// How much of making way an agent takes upon itself, beside another: shares are as these
    /// numbers. Zero: it is moved by others (a player, a vehicle), only looked at, and everybody
    /// else makes all the way.
    std::vector<float> yield;
    /// Along its path to its goal, m: of two that are in each other's way, who has less left goes
    /// first. The same for all (0) where nobody knows.
    std::vector<float> path_left;
    std::vector<std::uint32_t> id;  ///< what its random choices come from

    [[nodiscard]] std::size_t size() const { return x.size(); }

    void reserve(std::size_t agents) {
        for (auto* column : floats()) {
            column->reserve(agents);
        }
        id.reserve(agents);
    }

    /// Stands there until it is told what it wants.
    void add(std::uint32_t agent, float at_x, float at_z, float its_radius, float its_most_speed) {
        for (auto* column : floats()) {
            column->push_back(0.0F);
        }
        x.back() = at_x;
        z.back() = at_z;
        radius.back() = its_radius;
        most_speed.back() = its_most_speed;
        yield.back() = 1.0F;
        id.push_back(agent);
    }

    /// All of them go; memory stays.
    void clear() {
        for (auto* column : floats()) {
            column->clear();
        }
        id.clear();
    }

    /// The last row takes the place of `row`.
    void remove(std::size_t row) {
        for (auto* column : floats()) {
            (*column)[row] = column->back();
            column->pop_back();
        }
        id[row] = id.back();
        id.pop_back();
    }

  private:
    static constexpr std::size_t kFloats = 10;

    struct CrowdColumns {
        std::vector<float>* column[kFloats];

        [[nodiscard]] std::vector<float>* const* begin() const { return column; }

        [[nodiscard]] std::vector<float>* const* end() const { return column + kFloats; }
    };

    CrowdColumns floats() {
        return {{&x, &z, &vx, &vz, &want_x, &want_z, &radius, &most_speed, &yield, &path_left}};
    }
};

}  // namespace zoned::ai::steering
