// Codec plan: whose records are coded for one client alone, by counted demand and measured prices.
#pragma once

#include "server/mailbox/messages.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::replication {

/// What one client has been told per tick of late, whichever the codec: means that forget half in
/// about a second and a half of 30 ticks.
struct CodecDemand {
    float records = 0.0F;
    float packets = 0.0F;  ///< that carry records
    float use = 0.0F;      ///< of what may be sent to it: the share that shared records would take

    /// A tick in which so many records went out in so many packets; `allowed_bytes`: what may be
    /// sent to the client per tick, > 0.
    void add(std::uint32_t records_now, std::uint32_t packets_now, double allowed_bytes);

    /// What coding all of it costs, ns per tick.
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
    std::uint32_t little_to_gain = 0;  ///< clients that are told too little at a time
    double cost_ns = 0.0;              ///< per tick, of those coded
};

/// Codes where many records share a packet or where the downlink is short, those first whose
/// downlink is fullest, as long as all of it costs `budget_ns` per tick at most. Who is coded stays
/// so a while longer: a change of codec costs the client a few full records. Ties go by place.
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
    /// Who is coded is left alone down to this share of either, and counts for so much more.
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
