// CrowdAgents: the agents of a crowd, in columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::ai::steering {

/// Agents are discs on the ground. All columns have the same length; a row is an agent.
struct CrowdAgents {
    std::vector<float> x, z;            ///< m
    std::vector<float> vx, vz;          ///< m/s, as moved in the last step
    std::vector<float> want_x, want_z;  ///< m/s, desired velocity without others
    std::vector<float> radius;          ///< m, > 0
    std::vector<float> most_speed;      ///< m/s, >= 0
    /// The agent's share of avoiding another agent; shares are in proportion to these numbers.
    /// Zero: others move it (a player, a vehicle) or it is only an obstacle, and everybody else
    /// avoids it entirely.
    std::vector<float> yield;
    /// Distance along its path to its goal, m. Of two agents in conflict the one with less left
    /// goes first. It is the same for all (0) where it is unknown.
    std::vector<float> path_left;
    std::vector<std::uint32_t> id;  ///< seed of its random choices

    [[nodiscard]] std::size_t size() const { return x.size(); }

    void reserve(std::size_t agents) {
        for (auto* column : floats()) {
            column->reserve(agents);
        }
        id.reserve(agents);
    }

    /// Adds an agent that stands until its desired velocity is set.
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

    /// Removes all agents; keeps the memory.
    void clear() {
        for (auto* column : floats()) {
            column->clear();
        }
        id.clear();
    }

    /// Removes `row`; the last row takes its place.
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
