// SpringBatches: springs in colours; those of one colour share no node, so that lanes and threads
// take them in any order with the same result.
#pragma once

#include "server/physics/simd/lanes.h"
#include "server/physics/soft/soft_def.h"

#include <span>

namespace zoned::physics::soft {

/// A spring as a body keeps it.
struct Spring {
    std::uint32_t a, b;
    float rest;        ///< m, with permanent set
    float first_rest;  ///< m
    float stiffness;   ///< N/m
    float damping;     ///< N s/m
    SpringKind kind;
    bool alive;
};

/// Eight springs of one colour. Lanes that are left over repeat the first spring: they compute and
/// write the same once more.
struct SpringBatch {
    std::array<std::uint32_t, kLanes> a;
    std::array<std::uint32_t, kLanes> b;
    std::array<std::uint32_t, kLanes> spring;
    std::array<float, kLanes> rest;
    std::array<float, kLanes> compliance;  ///< m/N
    std::array<float, kLanes> lag;         ///< damping over stiffness, s
};

class SpringBatches {
  public:
    /// Colours by first fit in the order of the springs; dead ones are left out.
    void build(std::span<const Spring> springs, std::size_t nodes);
    /// Takes over rest lengths.
    void refresh(std::span<const Spring> springs);

    [[nodiscard]] std::size_t colours() const { return first_.empty() ? 0 : first_.size() - 1; }

    [[nodiscard]] std::span<const SpringBatch> colour(std::size_t c) const {
        return std::span(batches_).subspan(first_[c], first_[c + 1] - first_[c]);
    }

    [[nodiscard]] bool damped() const { return damped_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(batches_, first_, damped_);
    }

  private:
    std::vector<SpringBatch> batches_;
    std::vector<std::size_t> first_;  // of each colour, and the end
    bool damped_ = false;
};

}  // namespace zoned::physics::soft
