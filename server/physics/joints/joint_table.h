// JointTable: the joints of a scene and their state between steps.
#pragma once

#include "server/physics/bodies/bodies.h"
#include "server/physics/joints/joint_rows.h"
#include "server/physics/joints/joint_state.h"

#include <array>
#include <cstdint>
#include <vector>

namespace zoned::physics {

struct JointEntry : JointState {
    Joint joint;
    std::uint32_t a = kNoIndex;  ///< body rows; kNoIndex: the world
    std::uint32_t b = kNoIndex;
    std::array<std::uint32_t, 2> next{kNoIndex, kNoIndex};  ///< per side, in the body's list
    std::uint16_t generation = 0;
    bool alive = false;

    template <class Archive>
    void serialize(Archive& archive) {
        archive(impulse, straight_error, motion, substep_s, force_n);
        archive(joint, a, b, next, generation, alive);
    }
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

    template <class Archive>
    void serialize(Archive& archive) {
        archive(entries_, free_, size_);
    }

    /// Whether all numbers name joints and bodies that there are.
    [[nodiscard]] bool is_sound(const Bodies& bodies) const;

  private:
    void unlink(Bodies& bodies, std::uint32_t index, std::uint32_t side, std::uint32_t row);

    std::vector<JointEntry> entries_;
    std::vector<std::uint32_t> free_;
    std::uint32_t size_ = 0;
};

}  // namespace zoned::physics
