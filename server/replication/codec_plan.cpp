#include "server/replication/codec_plan.h"

#include <algorithm>

namespace zoned::replication {

namespace {

constexpr float kForget = 1.0F / 64.0F;
// The approximate size of a shared record and of a packet's headers. The demand of a client is
// measured alike, whichever codec it has.
constexpr double kSharedRecordBytes = 16.0;
constexpr double kHeaderBytes = 72.0;

bool gains(const CodecWish& wish) {
    const float least = wish.coded ? CodecPlan::kStay : 1.0F;
    const bool dense = wish.demand.records > 0.0F &&
                       wish.demand.records >= least * CodecPlan::kDense * wish.demand.packets;
    return dense || wish.demand.use >= least * CodecPlan::kShort;
}

}  // namespace

void CodecDemand::add(std::uint32_t records_now, std::uint32_t packets_now, double allowed_bytes) {
    const double bytes = kSharedRecordBytes * records_now + kHeaderBytes * packets_now;
    records += kForget * (static_cast<float>(records_now) - records);
    packets += kForget * (static_cast<float>(packets_now) - packets);
    use += kForget * (static_cast<float>(bytes / allowed_bytes) - use);
}

double CodecDemand::cost_ns(const mailbox::CodecPrice& price) const {
    return static_cast<double>(records) * price.record_ns +
           static_cast<double>(packets) * price.packet_ns;
}

CodecChoice CodecPlan::choose(std::span<CodecWish> wishes,
                              const mailbox::CodecPrice& price,
                              double budget_ns) {
    CodecChoice choice;
    order_.clear();
    for (std::uint32_t i = 0; i < wishes.size(); ++i) {
        CodecWish& wish = wishes[i];
        if (gains(wish)) {
            order_.push_back({wish.demand.use * (wish.coded ? kHeld : 1.0F), i});
        } else {
            ++choice.little_to_gain;
        }
        wish.coded = false;
    }
    std::sort(order_.begin(), order_.end(), [](const RankedClient& a, const RankedClient& b) {
        return a.score != b.score ? a.score > b.score : a.index < b.index;
    });
    for (const RankedClient& place : order_) {
        const double cost_ns = wishes[place.index].demand.cost_ns(price);
        if (choice.cost_ns + cost_ns > budget_ns) {
            ++choice.beyond_budget;
            continue;
        }
        choice.cost_ns += cost_ns;
        wishes[place.index].coded = true;
        ++choice.coded;
    }
    return choice;
}

}  // namespace zoned::replication
