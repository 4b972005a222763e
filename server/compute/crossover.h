// Crossover: chooses the faster side, CPU or device, for an amount of work by measured costs.
#pragma once

#include <cstddef>
#include <cstdint>

namespace zoned::compute {

enum class Side : std::uint8_t {
    kCpu,
    kDevice
};

/// The cost of a batch of n items on a side: launch_us + n (item_us + copy_us).
struct SideCost {
    double launch_us = 0.0;  ///< a batch of any size: starting, waiting
    double item_us = 0.0;    ///< work per item
    double copy_us = 0.0;    ///< transfers per item, in both directions; 0 where memory is shared

    [[nodiscard]] double of(std::size_t items) const {
        return launch_us + static_cast<double>(items) * (item_us + copy_us);
    }
};

/// The line through two measured batches, copies apart: the time of a small one and of a large one
/// (us) with their numbers of items. Slopes and launches below zero, which noise makes, become
/// zero.
SideCost cost_through(std::size_t few, double few_us, std::size_t many, double many_us);

/// The choice by work size. The owner of a clock measures both sides and sets the costs here; until
/// then the CPU does the work. The CPU also does work that enters state hashes and is not
/// bit-identical on the device. Two runs may choose differently, because the costs are measured.
/// Only bit-identical results on both sides keep a run repeatable, so each choice asks for
/// exactness.
class Crossover {
  public:
    Crossover() = default;

    Crossover(const SideCost& cpu, const SideCost& device)
        : cpu_(cpu),
          device_(device),
          measured_(true) {}

    [[nodiscard]] bool measured() const { return measured_; }

    /// `hashed`: the result enters a state hash. `exact`: both sides give the same bits.
    [[nodiscard]] Side choose(std::size_t items, bool hashed, bool exact) const;

    /// The fewest items for which the device is chosen; SIZE_MAX where there is no such number.
    /// (The device may be faster below another number instead: then this is 1, or SIZE_MAX.)
    [[nodiscard]] std::size_t threshold() const;

    [[nodiscard]] const SideCost& cpu() const { return cpu_; }

    [[nodiscard]] const SideCost& device() const { return device_; }

  private:
    SideCost cpu_;
    SideCost device_;
    bool measured_ = false;
};

}  // namespace zoned::compute
