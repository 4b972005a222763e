// Codec plan: selects the clients whose records are coded for them alone, by demand and price.
#pragma once

#include "server/mailbox/messages.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::replication {

/// The recent output to one client per tick, whichever the codec. The means forget half in about a
/// second and a half of 30 ticks.
struct CodecDemand {
    float records = 0.0F;
    float packets = 0.0F;  ///< that carry records
    float use = 0.0F;      ///< the share of its allowance that shared records would take

    /// A tick in which so many records went out in so many packets; `allowed_bytes`: the client's
    /// allowance per tick, > 0.
    void add(std::uint32_t records_now, std::uint32_t packets_now, double allowed_bytes);

    /// The cost of coding all of it, ns per tick.
    [[nodiscard]] double cost_ns(const mailbox::CodecPrice& price) const;
};

/// One client as the plan sees it.
struct CodecWish {
    CodecDemand demand;
    bool coded = false;  ///< before and after
};

struct CodecChoice {
    std::uint32_t coded = 0;           ///< clients
    std::uint32_t beyond_budget = 0;   ///< clients that would gain, but there is no time for them
    std::uint32_t little_to_gain = 0;  ///< clients that are sent too little at a time
    double cost_ns = 0.0;              ///< per tick, of those coded
};

/// Codes for clients with many records in a packet or with a short downlink. The fullest downlinks
/// come first, as long as all of it costs at most `budget_ns` per tick. A coded client stays coded
/// a while longer, because a change of codec costs it a few full records. Ties go by place.
class CodecPlan {
  public:
    CodecChoice choose(std::span<CodecWish> wishes,
                       const mailbox::CodecPrice& price,
                       double budget_ns);

    /// Ticks between two choices.
    static constexpr Tick kEvery = 30;

    /// Records of a packet from which coding pays for the head of the code and its warming up.
    static constexpr float kDense = 4.0F;
    /// Use of the downlink from which fewer bytes are wanted however few records there are.
    static constexpr float kShort = 0.5F;
    /// A coded client is left alone down to this share of either, and counts for so much more.
    static constexpr float kStay = 0.5F;
    static constexpr float kHeld = 1.25F;

  private:
    struct RankedClient {
        float score = 0.0F;
        std::uint32_t index = 0;
    };

    std::vector<RankedClient> order_;  // scratch
};

}  // namespace zoned::replication
