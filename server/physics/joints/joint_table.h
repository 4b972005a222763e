// JointTable: the joints of a scene and their state between steps.
#pragma once

#include "server/physics/bodies/bodies.h"
#include "server/physics/joints/joint_rows.h"
#include "server/physics/simd/lanes.h"

#include <array>
#include <cstdint>
#include <vector>

namespace zoned::physics {

struct JointEntry {
    Joint joint;
    std::uint32_t a = kNoIndex;  ///< body rows; kNoIndex: the world
    std::uint32_t b = kNoIndex;
    std::array<std::uint32_t, 2> next{kNoIndex, kNoIndex};  ///< per side, in the body's list
    std::array<float, kMostRows> impulse{};                 ///< per row and substep
    std::array<float, kMostRows> straight_error{};          ///< per row, m or rad: see JointSolver
    std::array<Row8, 2> motion{};                           ///< of a and b when the step ended
    float substep_s = 0.0F;                                 ///< length of these substeps
    float force_n = 0.0F;                                   ///< size of the force of the last one
    std::uint16_t generation = 0;
    bool alive = false;
};

/// Rows of removed joints are reused with a higher generation. Each body has a list of its joints.
class JointTable {
  public:
    JointId add(Bodies& bodies, const Joint& joint, std::uint32_t a, std::uint32_t b);
    void remove(Bodies& bodies, std::uint32_t index);

    /// The index of an id, or kNoIndex when no such joint lives.
    [[nodiscard]] std::uint32_t index_of(JointId id) const;
    [[nodiscard]] JointId id_of(std::uint32_t index) const;

    JointEntry& operator[](std::uint32_t index) { return entries_[index]; }

    const JointEntry& operator[](std::uint32_t index) const { return entries_[index]; }

    [[nodiscard]] std::uint32_t rows() const { return static_cast<std::uint32_t>(entries_.size()); }

    [[nodiscard]] std::uint32_t size() const { return size_; }

    /// True when a joint forbids the two to collide.
    [[nodiscard]] bool parts(const Bodies& bodies, std::uint32_t a, std::uint32_t b) const;

    /// Calls visit(index, row of the other body or kNoIndex) for each joint of a body. The visitor
    /// may remove the joint that it is given.
    template <class Visit>
    void for_each_of(const Bodies& bodies, std::uint32_t row, Visit&& visit) const {
        for (std::uint32_t link = bodies.first_joint[row]; link != kNoIndex;) {
            const JointEntry& entry = entries_[link >> 1];
            const std::uint32_t next = entry.next[link & 1];
            visit(link >> 1, (link & 1) == 0 ? entry.b : entry.a);
            link = next;
        }
    }

  private:
    void unlink(Bodies& bodies, std::uint32_t index, std::uint32_t side, std::uint32_t row);

    std::vector<JointEntry> entries_;
    std::vector<std::uint32_t> free_;
    std::uint32_t size_ = 0;
};

}  // namespace zoned::physics
