#include "server/app/calibration/measure_codec.h"

#include "server/app/runtime/tick_loop.h"
#include "shared/core/rng.h"
#include "shared/wire/record/record_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::app {

namespace {

constexpr std::uint32_t kFewRecords = 4;
constexpr std::uint32_t kManyRecords = 32;
constexpr wire::entropy::PacketNumber kUnderWay = 4;
constexpr wire::entropy::PacketNumber kWarmUpPackets = 8;
constexpr wire::entropy::PacketNumber kTimedPackets = 8;
constexpr std::size_t kCodecRuns = 3;
constexpr std::uint32_t kClients = 64;
constexpr float kCodecTickS = 1.0F / 30.0F;

/// Walks straight on, and now and then in another direction.
struct TrialWalker {
    motion::KinematicState state;

    void step(core::Rng& rng) {
        if (rng.below(8) == 0) {
            state.velocity = Vec3(rng.range(-5.0F, 5.0F), 0.0F, rng.range(-5.0F, 5.0F));
        }
        state.position += kCodecTickS * state.velocity;
    }
};

/// An encoder of one client, as one of many: its model is not in the nearest cache when its turn
/// comes.
struct CodecTrial {
    explicit CodecTrial(std::uint32_t walkers)
        : encoder(wire::record::RecordFormat(wire::Quantization(), kCodecTickS)),
          all(walkers),
          records(walkers) {}

    /// CPU time of the packet, ns.
    std::uint64_t packet(wire::entropy::PacketNumber number, core::Rng& rng) {
        for (std::uint32_t i = 0; i < all.size(); ++i) {
            all[i].step(rng);
            records[i].entity = EntityId(i + 1);
            records[i].upright = true;
            records[i].tick = static_cast<Tick>(number);
            records[i].state = wire::quantize(all[i].state,
                                              motion::PredictorOrder::kLinear,
                                              true,
                                              false,
                                              0,
                                              wire::Quantization());
        }
        bytes.clear();
        const std::uint64_t begin_ns = thread_cpu_ns();
        if (number > kUnderWay) {
            encoder.acknowledge(number - kUnderWay);
        }
        encoder.sent(encoder.encode(number, static_cast<Tick>(number), ZoneId(1), records, bytes));
        return thread_cpu_ns() - begin_ns;
    }

    wire::record::RecordEncoder encoder;
    std::vector<TrialWalker> all;
    std::vector<wire::record::CodedRecord> records;
    std::vector<std::uint8_t> bytes;
};

/// CPU time of a packet that tells of so many walkers, ns.
double packet_ns(std::uint32_t walkers) {
    std::vector<CodecTrial> trials(kClients, CodecTrial(walkers));
    core::Rng rng(1);
    std::uint64_t spent_ns = 0;
    for (wire::entropy::PacketNumber number = 1; number <= kWarmUpPackets + kTimedPackets;
         ++number) {
        for (CodecTrial& trial : trials) {
            const std::uint64_t one_ns = trial.packet(number, rng);
            spent_ns += number > kWarmUpPackets ? one_ns : 0;
        }
    }
    return static_cast<double>(spent_ns) / static_cast<double>(kTimedPackets * kClients);
}

double median_packet_ns(std::uint32_t walkers) {
    std::array<double, kCodecRuns> times{};
    for (double& time : times) {
        time = packet_ns(walkers);
    }
    std::sort(times.begin(), times.end());
    return times[kCodecRuns / 2];
}

/// At least one: work at no cost would be bought without end.
std::uint32_t whole_ns(double ns) {
    return static_cast<std::uint32_t>(std::lround(std::clamp(ns, 1.0, 1e9)));
}

}  // namespace

mailbox::CodecPrice measure_codec() {
    const double few = median_packet_ns(kFewRecords);
    const double many = median_packet_ns(kManyRecords);
    const double record =
        std::max((many - few) / static_cast<double>(kManyRecords - kFewRecords), 1.0);
    return {whole_ns(record), whole_ns(few - record * static_cast<double>(kFewRecords))};
}

}  // namespace zoned::app
